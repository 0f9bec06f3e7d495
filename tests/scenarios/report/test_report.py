"""Printed report and verdict: numbers of the result, within the width of a terminal."""

from dataclasses import replace

import pytest
from support import short_run

from luxloop.scenarios.document.document import plain
from luxloop.scenarios.files.expect import Check, Limit, check, verdict
from luxloop.scenarios.metrics.definitions import DEFINITIONS, REPORTED_BANDS
from luxloop.scenarios.report import run_tables
from luxloop.scenarios.report.cells import NONE
from luxloop.scenarios.report.text import WIDTH, as_text, report
from luxloop.scenarios.result import Metric


def text_of(result, checks=()):
    return as_text(report(result, list(checks)))


def row(text, title, first_cell):
    """Return the cells of the first row after `title` that starts with `first_cell`."""
    lines = text[text.index(title) :].splitlines()
    return next(line for line in lines if line.startswith(first_cell)).removeprefix(first_cell).split()


def with_metrics(values):
    """Return the short result with replaced metrics."""
    result = short_run.result()
    return replace(result, metrics=result.metrics | values)


def test_data_set_table_shows_metrics():
    result = with_metrics(
        {
            "dataset.observations_per_frame": Metric(4.25, "1", 100),
            "dataset.observations{view=rear}": Metric(17.0, "count", 100),
            "dataset.share{view=rear}": Metric(0.04, "1", 425),
            "dataset.observations{view=front}": Metric(3.0, "count", 100),
            "dataset.share{view=front}": Metric(0.0071, "1", 425),
        }
    )
    text = text_of(result)
    assert row(text, "Data set", "observations per frame") == ["4.2"]
    assert row(text, "Data set", "view: rear") == ["17", "4.0%"]
    assert row(text, "Data set", "view: front") == ["3", "0.7%"]


def test_heading_table_shows_metrics():
    result = with_metrics(
        {
            "fit.heading_mean_deg": Metric(-0.25, "deg", 77),
            "fit.heading_std_deg": Metric(1.5, "deg", 77),
            "fit.heading_abs_mean_deg": Metric(1.125, "deg", 77, interval=(0.875, 1.5)),
            "fit.heading_abs_std_deg": Metric(0.75, "deg", 77),
        }
    )
    text = text_of(result)
    expected = ["-0.250", "1.500", "1.125", "0.875-1.500", "0.750", "77"]
    assert row(text, "Fit heading error by method", "best") == expected


def test_enabled_baseline_is_shown():
    """Fails when a table has a fixed list of methods."""
    assert "jlinkage" not in text_of(short_run.result())
    names = [
        f"fit.{name}{{method=jlinkage}}" for name in ("heading_mean_deg", "heading_abs_mean_deg", "rounded_to_0deg")
    ]
    text = text_of(with_metrics(dict.fromkeys(names, Metric(0.5, "deg", 9))))
    assert row(text, "Fit heading error by method", "jlinkage")[0] == "0.500"
    assert row(text, "Share of fit heading errors", "jlinkage")[0] == "50.0%"


def test_distribution_table_shows_metrics():
    shares = {f"fit.within_{n}deg{{method=area}}": Metric(n / 10, "1", 9, interval=(0.0, n / 5)) for n in range(1, 6)}
    shares["fit.rounded_to_0deg{method=area}"] = Metric(0.05, "1", 9)
    text = text_of(with_metrics(shares))
    expected = ["5.0%", "10.0%", "0-20", "20.0%", "0-40", "30.0%", "0-60", "40.0%", "0-80", "50.0%", "0-100"]
    assert row(text, "Share of fit heading errors", "area") == expected


def test_fit_tables_show_metrics_by_band_and_by_view():
    changed = {
        "fit.heading_abs_mean_deg{method=variance,range=15-30}": Metric(1.5, "deg", 20),
        "fit.heading_abs_mean_deg{method=variance,points=100-}": Metric(0.25, "deg", 21),
        "fit.regret_deg{view=rear}": Metric(0.75, "deg", 40, interval=(0.5, 1.0)),
        "fit.coverage_50{view=rear}": Metric(0.51, "1", 39),
        "fit.coverage_90{view=rear}": Metric(0.88, "1", 39),
        "fit.coverage_99{view=rear}": Metric(0.97, "1", 39),
        "fit.bound_ratio{view=rear}": Metric(2.5, "1", 38),
        "fit.regret_deg{points=0-30}": Metric(1.25, "deg", 30),
        "fit.corner_across_mean_m{view=rear}": Metric(-0.125, "m", 40),
        "fit.corner_across_abs_mean_m{view=rear}": Metric(0.175, "m", 40),
    }
    text = text_of(with_metrics(changed))
    by_band = row(text, "Mean absolute fit heading error by range", "variance")
    assert (by_band[1], by_band[5]) == ("1.500", "0.250")
    selected = row(text, "Selected fits: regret", "rear")
    assert selected == ["0.750", "0.500-1.000", "51.0%", "88.0%", "97.0%", "2.500", "40"]
    assert row(text, "Selected fits: regret", "0-30 points")[0] == "1.250"
    assert row(text, "Selected fits: nearest corner", "rear")[2:4] == ["-0.125", "0.175"]


def test_position_table_shows_metrics():
    result = with_metrics(
        {
            "mma.x_abs_mean_m{target=moving}": Metric(0.1, "m", 31, interval=(0.09, 0.12)),
            "mma.x_abs_std_m{target=moving}": Metric(0.2, "m", 31),
            "mma.y_abs_mean_m{target=moving}": Metric(0.3, "m", 31),
            "mma.y_abs_std_m{target=moving}": Metric(0.4, "m", 31),
        }
    )
    text = text_of(result)
    rows = [line.split() for line in text[text.index("Absolute error of the tracked corner") :].splitlines()]
    assert ["mma", "moving", "0.100", "0.090-0.120", "0.200", "0.300", "0.400", "31"] in rows


def test_tables_of_mode_confusion_and_model_consistency():
    result = with_metrics(
        {
            "mma.selected{mode=ca,model=stationary}": Metric(0.05, "1", 40),
            "mma.selected{mode=ca,model=cv}": Metric(0.2, "1", 40),
            "mma.selected{mode=ca,model=ca}": Metric(0.75, "1", 40),
            "mma.nees_in_band{model=ca}": Metric(0.9, "1", 40),
            "mma.nees_mean{model=ca}": Metric(2.5, "1", 40),
            "mma.nis_in_band{model=ca}": Metric(0.8, "1", 40),
            "mma.nis_mean{model=ca}": Metric(1.5, "1", 40),
        }
    )
    text = text_of(result)
    assert row(text, "Selected model by true mode", "ca") == ["5.0%", "20.0%", "75.0%", "40"]
    assert row(text, "Consistency of the filters", "ca") == ["90.0%", "2.500", "80.0%", "1.500", "40"]


def test_table_of_both_drives_of_a_controlled_ego():
    title = "Controlled ego"
    assert title not in text_of(short_run.result())
    result = with_metrics(
        {
            "control.min_ttc_s": Metric(1.75, "s", 80),
            "control.truth_min_ttc_s": Metric(2.25, "s", 70),
            "control.collisions": Metric(1.0, "count", 100),
            "control.truth_collisions": Metric(0.0, "count", 100),
        }
    )
    text = text_of(replace(result, config={**result.config, "control": {"kind": "cruise"}}))
    assert row(text, title, "least true time to collision")[-3:] == ["[s]", "1.750", "2.250"]
    assert row(text, title, "actors that the ego collided with [count]") == ["1", "0"]
    assert row(text, title, "least true gap")[-2:] == [NONE, NONE]


def test_brackets_in_titles_and_descriptions_are_kept():
    """In rich's markup, [deg] and [bold] would be styles."""
    text = text_of(short_run.result())
    for expected in ("modulo 90 degrees [deg]", "by view [deg]", "ego's axes [m]", "Time per frame [ms]", "ego [bold]"):
        assert expected in text


def test_report_shows_seed_trace_hash_and_limits_of_grading():
    result = short_run.result()
    text = " ".join(text_of(result).split())
    assert f"seed 4, 10 frames, trace {result.trace_hash}" in text
    limits = {name: value for name, value in result.config["grading"].items() if name != "target"}
    assert all(f"{name} = {value:g}" in text for name, value in limits.items())


def test_the_emergence_of_a_named_target_is_shown():
    assert "Emergence" not in text_of(short_run.result())
    result = with_metrics(
        {
            "emergence.time_s{stage=confirmed}": Metric(0.16, "s", 1),
            "emergence.delay_s{stage=confirmed}": Metric(0.08, "s", 1),
            "emergence.range_m{stage=confirmed}": Metric(9.5, "m", 1),
            "emergence.meeting_m{stage=confirmed}": Metric(4.25, "m", 1),
            "emergence.meeting_s{stage=confirmed}": Metric(0.5, "s", 1),
        }
    )
    grading = result.config["grading"] | {"target": "[car]"}
    text = text_of(replace(result, config={**result.config, "grading": grading}))
    assert row(text, "Emergence of [car]", "confirmed") == ["0.16", "0.08", "9.50", NONE, "4.25", "0.50"]


def test_metric_without_value_is_shown_with_its_reason():
    result = with_metrics({"track.hota": Metric(None, "1", 0, "nothing was graded")})
    assert row(text_of(result), "Tracking", "track.hota") == [NONE, "0", "nothing", "was", "graded"]


def test_lines_are_within_the_width_of_the_report():
    assert max(map(len, text_of(short_run.result()).splitlines())) <= WIDTH


@pytest.mark.parametrize(
    ("value", "limit", "passes"),
    [
        (0.5, Limit(min=0.5), True),
        (0.5, Limit(max=0.5), True),
        (0.49, Limit(min=0.5), False),
        (0.51, Limit(max=0.5), False),
        (0.6, Limit(min=0.5, max=0.7), True),
        (0.8, Limit(min=0.5, max=0.7), False),
        (0.0, Limit(max=0.0), True),
        (None, Limit(max=0.0), False),
    ],
)
def test_expectation_holds_at_its_limits_and_not_without_a_value(value, limit, passes):
    (outcome,) = check({"track.hota": Metric(value, "1", 1)}, {"track.hota": limit})
    assert outcome.holds is passes
    assert verdict([outcome], complete=True) == ("passed" if passes else "failed")


def test_failed_expectation_fails_the_run_and_is_shown_with_limit_and_value():
    metric = Metric(0.625, "1", 3)
    good, bad = Check("track.mota", Limit(max=1.0), metric), Check("track.hota", Limit(min=0.75), metric)
    text = text_of(short_run.result(), [good, bad])
    assert verdict([good, bad], complete=True) == "failed"
    assert row(text, "Expectations", "track.hota") == [">=", "0.75", "0.625", "FAILED"]
    assert row(text, "Expectations", "track.mota") == ["<=", "1", "0.625", "passed"]
    assert text.startswith("FAILED: 1 of 2 expectations hold, 1 failed")


def test_incomplete_run_neither_passes_nor_fails_and_shows_the_reason():
    """Expectations on the first frames do not decide about the complete run."""
    good, bad = (Check("track.mota", Limit(max=top), Metric(0.625, "1", 3)) for top in (1.0, 0.5))
    assert verdict([], complete=False) == verdict([good], complete=False) == verdict([bad], complete=False)
    text = text_of(replace(short_run.result(), ended_early="the ego arrived"), [good, bad])
    assert text.startswith("INCOMPLETE: ended early: the ego arrived; so far 1 of 2 expectations hold, 1 failed")


def test_bands_of_the_tracks_have_a_row_each_on_the_page_and_none_in_the_printed_report():
    result = with_metrics(
        {
            "track.missed_share{class=trailer_truck}": Metric(0.25, "1", 40),
            "track.length_mean_m{class=trailer_truck}": Metric(-1.5, "m", 30),
            "track.missed_share{range=15-30}": Metric(0.125, "1", 8),
        }
    )
    found, _ = run_tables.tracks_by_band(result)
    rows = {first: others for first, *others in ([plain(cell) for cell in row.cells] for row in found.rows)}
    assert (rows["class trailer truck"][0], rows["class trailer truck"][3]) == ("0.250", "-1.500")
    assert (rows["range 15-30 m"][0], rows["range 15-30 m"][-1]) == ("0.125", "8")
    assert len(rows) == len(REPORTED_BANDS)
    assert "class=" not in text_of(result)


def test_every_track_metric_has_a_row_with_its_interval():
    changed = {f"track.{name}": Metric(0.5, "1", 9, interval=(0.25, 0.75)) for name in ("hota", "idf1")}
    changed["track.length_mean_m"] = Metric(-0.5, "m", 9, interval=(-0.75, 0.25))
    text = text_of(with_metrics(changed))
    assert row(text, "Tracking", "track.hota")[:3] == ["0.500", "0.250-0.750", "9"]
    assert row(text, "Tracking", "track.idf1")[:3] == ["0.500", "0.250-0.750", "9"]
    assert row(text, "Motion, track heading", "track.length_mean_m")[:4] == ["-0.500", "-0.750", "to", "0.250"]
    for name, definition in DEFINITIONS.items():
        assert not name.startswith("track.") or definition.needs or f"\n{name} " in text, name
