"""Run the scenario `ring` with each kind of noise alone and write the heading errors to docs/ablation.md.

    python docs/ablation.py

It takes about four minutes on one core, and its result is reproducible: tables between `<!-- NAME -->` and
`<!-- end -->`, and docs/pictures/ablation.png.
"""

import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import numpy.typing as npt
import pandas as pd

from luxloop.scenarios.files.scenario import Scenario
from luxloop.scenarios.files.shipped import find
from luxloop.scenarios.metrics.definitions import VIEWS
from luxloop.scenarios.report import paper_comparison
from luxloop.scenarios.run import device, loop
from luxloop.sensor_model.lidar import Lidar
from luxloop.sensor_model.noise.noise_config import KINDS, NoiseConfig
from luxloop.sensor_model.rig.rig import load_rig
from luxloop.sensor_model.truth import Cause
from luxloop.sim.scripted.scripted_source import ScriptedSource

PAGE = Path(__file__).parent / "ablation.md"
PICTURE = Path(__file__).parent / "pictures" / "ablation.png"

PAPER = ("dropout", "mirror", "layer_overlap")
SHAPES = ("mirror", "layer_overlap")
"""Kinds whose effect depends on the view of a car."""
BASE = ("range", "dropout")
DEFAULT = tuple(kind for kind in KINDS if getattr(NoiseConfig(), kind).enabled)
CRITERIA = {"area": "area", "closeness": "closeness", "variance": "variance", "tlinkage": "T-linkage", "best": "best"}
"""Criteria of the paper and the selection among them, by their names in the table `fits`."""
CAUSE_OF = {
    "mirror": Cause.MIRROR,
    "layer_overlap": Cause.LAYER_OVERLAP,
    "ghost": Cause.GHOST,
    "calibration": Cause.DOUBLED,
    "outliers": Cause.RANGE_OUTLIER,
    "false_alarms": Cause.FALSE_ALARM,
    "rain": Cause.RAIN,
    "snow": Cause.SNOW,
    "fog": Cause.FOG,
}
"""Cause of the points that a kind of noise adds or moves."""
AROUND_M = 1.0
"""A point counts for a car if it is in its box enlarged by this on all sides [m]."""
OUTSIDE_M = 0.05
"""Distance outside of a box that exact ranges reach only on mirrors [m]."""
NEAR_DEG = 3.0
SEEDS = (1, 2, 3)
LEAST_DEG = 0.02
"""Changes of less than this, or than a tenth, are grey [deg]."""


@dataclass(frozen=True)
class Row:
    """Run of the scenario with these kinds of noise, at their default strengths."""

    name: str
    kinds: tuple[str, ...]
    seed: int = 1

    def scenario(self) -> Scenario:
        """Return the scenario of the run."""
        noise: dict[str, dict[str, object]] = {kind: {"enabled": kind in self.kinds} for kind in KINDS}
        noise["attitude"]["full_from_mps"] = 0.0  # the ego stands; it sways as when it drives
        return Scenario.load(find("ring"), {"noise": noise, "seed": self.seed})


NONE = Row("none", ())
ALONE = [Row(kind, (kind,)) for kind in KINDS]
TOGETHER = [
    Row("the paper's three: " + ", ".join(PAPER), PAPER),
    Row("default: " + ", ".join(DEFAULT), DEFAULT),
    Row("all", KINDS),
]
ON_BASE = [Row(" + ".join(BASE), BASE)] + [Row(f"+ {kind}", (*BASE, kind)) for kind in KINDS if kind not in BASE]
OTHER_SEEDS = [Row(f"{row.name.partition(':')[0]}, seed {seed}", row.kinds, seed)
               for row in (NONE, TOGETHER[1]) for seed in SEEDS]  # fmt: skip
PAPERS_OWN = [
    "the paper's recordings",
    *(f"{paper_comparison.HEADING_ABS_DEG[name][0]:.3f}" for name in CRITERIA),
    "5353",
]


def main() -> None:
    """Run all rows, then write the page and the picture."""
    runs = {row: fit_errors(row) for row in dict.fromkeys([NONE, *ALONE, *TOGETHER, *ON_BASE, *OTHER_SEEDS])}
    tables = {
        "alone": error_table([NONE, *ALONE, *TOGETHER], runs, PAPERS_OWN),
        "base": error_table(ON_BASE, runs),
        "seeds": error_table(OTHER_SEEDS, runs),
        "views": view_table([NONE, *(row for row in ALONE if row.name in SHAPES), TOGETHER[0]], runs),
        "touched": touched_table([row for row in ALONE if row.name in CAUSE_OF], runs),
        "facts": diagonal_fact(runs[NONE]) + mirror_fact(TOGETHER[0]),
    }
    text = PAGE.read_text(encoding="utf-8")
    for name, table in tables.items():
        text = written(text, name, table)
    PAGE.write_text(text, encoding="utf-8")
    draw([NONE, *ALONE, *TOGETHER], runs)


def fit_errors(row: Row) -> pd.DataFrame:
    """Return the observations (frame, actor) of a run: |heading error| [deg] by criterion, view, and box diagonal."""
    print(row.name, file=sys.stderr, flush=True)
    fits = loop.run(row.scenario(), device.load(device.SHIPPED)).tables["fits"]
    fits = fits.assign(error=fits["heading_error_deg"].abs()).astype({"method": str, "view": str})
    fits["diagonal_deg"] = np.degrees(np.arctan2(fits["true_width_m"], fits["true_length_m"]))
    both = pd.concat([fits, fits[fits["best"]].assign(method="best")])
    errors = both.pivot_table(index=["frame", "actor_id"], columns="method", values="error")[[*CRITERIA]]
    return errors.join(fits.groupby(["frame", "actor_id"])[["view", "diagonal_deg"]].first())


@dataclass(frozen=True)
class CarPoints:
    """Points in and around one car of a scan."""

    frame: int
    actor: int
    cause: npt.NDArray[np.uint8]
    outside_m: npt.NDArray[np.float64]
    """Distance outside of its box, negative inside."""


def car_points(row: Row) -> Iterator[CarPoints]:
    """Simulate the scenario without tracker, with the same points as in the run."""
    scenario = row.scenario()
    rig = load_rig(str(scenario.rig), scenario.folder)
    source = ScriptedSource(scenario.traffic, scenario.folder, range_m=200.0)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, source.reset(scenario.seed))
    for _ in range(round(scenario.duration_s / source.dt)):
        frame = source.step()
        scan, truth = lidar.scan(frame)
        for actor, pose, size in zip(frame.actors.id, frame.actors.pose_world, frame.actors.size, strict=True):
            turn = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
            # The ego of the ring is at the world's origin.
            outside = (np.abs((scan.points_ego[:, :2] - pose[:2]) @ turn) - 0.5 * size[:2]).max(axis=1)
            near = outside < AROUND_M
            yield CarPoints(frame.index, int(actor), truth.cause[near], outside[near])


def touched_table(rows: list[Row], runs: dict[Row, pd.DataFrame]) -> str:
    """Return a Markdown table of the errors of observations with points of a kind of noise, without → with it."""
    cells = []
    for row in rows:
        counts = pd.Series(
            {(car.frame, car.actor): np.count_nonzero(car.cause == CAUSE_OF[row.name]) for car in car_points(row)}
        )
        both = runs[row].index.intersection(runs[NONE].index)
        touched = both[counts.reindex(both).to_numpy() > 0]
        pairs = [(runs[NONE].loc[touched, name].mean(), runs[row].loc[touched, name].mean()) for name in CRITERIA]
        changes = [f"{before:.2f} → {after:.2f}" if len(touched) else "" for before, after in pairs]
        cells.append([f"`{row.name}`", f"{counts[both].mean():.3g}", f"{len(touched) / len(both):.1%}", *changes])
    return as_markdown(["noise alone", "its points a car", "cars touched", *CRITERIA.values()], cells)


def diagonal_fact(errors: pd.DataFrame) -> str:
    """Return a sentence on the headings of the area criterion for perfect L shapes."""
    corner = errors[errors["view"] == "l_shape"]
    right = corner["area"].lt(NEAR_DEG).mean()
    diagonal = (corner["area"] - corner["diagonal_deg"]).abs().lt(NEAR_DEG).mean()
    return (
        f"- With no noise at all, {diagonal:.0%} of the area criterion's headings on L shapes are within {NEAR_DEG:g} "
        f"degrees of the box's diagonal, and {right:.0%} within {NEAR_DEG:g} degrees of the truth.\n"
    )


def mirror_fact(row: Row) -> str:
    """Return a sentence on the share of points outside of boxes with the label MIRROR."""
    causes = np.concatenate([car.cause[car.outside_m > OUTSIDE_M] for car in car_points(row)])
    labelled = np.mean(causes == Cause.MIRROR)
    return (
        f"- Of the {len(causes)} points that lie more than {100 * OUTSIDE_M:g} cm outside of their car's box with "
        f"{row.name.partition(':')[0]}, {labelled:.0%} are labelled `MIRROR`.\n"
    )


def view_table(rows: list[Row], runs: dict[Row, pd.DataFrame]) -> str:
    """Return a Markdown table of mean absolute heading errors [deg] by view and criterion."""
    cells = []
    for row in rows:
        for view in VIEWS.values():
            errors = runs[row][runs[row]["view"] == view]
            means = [f"{errors[criterion].mean():.2f}" for criterion in CRITERIA]
            cells.append([as_code(row), view.replace("_", " "), *means, str(len(errors))])
    return as_markdown(["noise", "view", *CRITERIA.values(), "observations"], cells)


def error_table(rows: list[Row], runs: dict[Row, pd.DataFrame], *more: list[str]) -> str:
    """Return a Markdown table of mean absolute heading errors [deg] by criterion, with further rows below."""
    cells = []
    for row in rows:
        means = [f"{runs[row][criterion].mean():.3f}" for criterion in CRITERIA]
        cells.append([as_code(row), *means, str(len(runs[row]))])
    return as_markdown(["noise", *CRITERIA.values(), "observations"], [*cells, *more])


def as_code(row: Row) -> str:
    """Return the name of a row, with keys of a scenario file as code."""
    return f"`{row.name}`" if row.name in KINDS else row.name


def as_markdown(head: list[str], rows: Iterable[list[str]]) -> str:
    """Return a Markdown table with right-aligned numbers."""
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def written(text: str, name: str, table: str) -> str:
    """Return a page with the block of this name replaced."""
    pattern = rf"(<!-- {name} -->\n).*?(<!-- end -->)"
    return re.sub(pattern, lambda match: match[1] + table + match[2], text, flags=re.DOTALL)


def draw(rows: list[Row], runs: dict[Row, pd.DataFrame]) -> None:
    """Draw the errors as bars: a panel per criterion, a bar per run, a line for the run without noise."""
    names = [row.name.partition(":")[0].replace("_", " ") for row in rows]
    means = pd.DataFrame([runs[row][[*CRITERIA]].mean() for row in rows])
    place = np.arange(len(rows))[::-1] - 0.5 * np.array([row in TOGETHER for row in rows])
    figure, panels = plt.subplots(1, len(CRITERIA), figsize=(11, 5.2), sharey=True, layout="constrained")
    for axes, (criterion, title) in zip(panels, CRITERIA.items(), strict=True):
        values, without = means[criterion], means[criterion].iloc[rows.index(NONE)]
        change = values.to_numpy() - without
        matters = np.abs(change) > np.maximum(0.1 * without, LEAST_DEG)
        colors = np.where(matters, np.where(change > 0.0, "tab:red", "tab:blue"), "0.6")
        axes.barh(place, values, color=colors, height=0.7)
        axes.axvline(without, color="black", linewidth=0.8)
        for y, value in zip(place, values, strict=True):
            axes.text(value, y, f" {value:.2f}", va="center", fontsize=7)
        axes.set(title=title, xlim=(0.0, 1.25 * values.max()), xlabel="mean |heading error| [deg]")
        axes.xaxis.label.set_size(8)
        axes.tick_params(labelsize=8)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_yticks(place, names)
    figure.suptitle(
        "Ring scenario, one kind of noise at a time (red: clearly worse than with none, blue: clearly better)",
        fontsize=10,
    )
    figure.savefig(PICTURE, dpi=90)
    plt.close(figure)


if __name__ == "__main__":
    main()
