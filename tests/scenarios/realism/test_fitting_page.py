"""The chapter on fitting of docs/realism.md: its table is made of what `luxloop fits --json` prints."""

from blocks import claims
from blocks.fitting import VIEWS, table_of

from luxloop.scenarios.realism.fit_observations import VIEWS as KNOWN


def source(best, clusters=20):
    figures = {"alignment": [2.0, [1.0, 3.0]], "tlinkage": [4.0, None], "best": [best, [1.5, 2.5]]}
    return {
        "clusters": 100, "vehicles": 9, "error_deg": figures,
        "best_minus_deg": {"alignment": [-0.5, [-1.0, 0.25]], "tlinkage": [-2.0, None]},
        "by_view_or_range_deg": {"end on": {"clusters": clusters, "best": 5.0}},
        "coverage_percent": {"50": [54.4, None], "99": [98.0, None]},
    }  # fmt: skip


def test_the_table_has_a_column_for_each_source_and_leaves_out_views_of_few_clusters():
    """Fails if columns are swapped, a sign is lost, or a mean of three clusters is shown."""
    text = table_of({"street roof": source(2.0), "street bumper": source(1.5, clusters=3), "simulated": source(3.0)})
    assert text.splitlines()[0] == "|  | real, bumper | real, roof | simulated |"
    assert claims.cell(text, "best", "real, bumper") == "1.50 [1.50, 2.50]"
    assert claims.cell(text, "best minus alignment", "simulated") == "-0.50 [-1.00, +0.25]"
    assert claims.cell(text, "best, end on", "real, bumper") == ""
    assert claims.cell(text, "best, end on", "real, roof") == "5.00"
    assert claims.cell(text, "50 / 99 % intervals contain", "simulated") == "54 / 98 %"


def test_views_are_those_of_the_command():
    assert set(VIEWS) <= set(KNOWN)
