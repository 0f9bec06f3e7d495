"""Runs the scenario `ring` with each kind of noise alone and writes what it does to the heading into docs/ablation.md.

    python docs/ablation.py

It takes some six minutes of one core, and its result is the same every time: tables between `<!-- NAME -->` and
`<!-- end -->`, and docs/pictures/ablation.png.
"""

import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd

from scenarios import device, loop
from scenarios.listing import find
from scenarios.scenario import Scenario
from sensor_model.lidar import Lidar
from sensor_model.noise.config import NoiseConfig
from sensor_model.rig import load_rig
from sensor_model.truth import Cause
from sim.scripted import ScriptedSource

PAGE = Path(__file__).parent / "ablation.md"
PICTURE = Path(__file__).parent / "pictures" / "ablation.png"

KINDS = tuple(field.name for field in fields(NoiseConfig))
PAPER = ("dropout", "mirror", "layer_overlap")
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
}
"""What points are labelled with that a kind of noise adds or moves."""
AROUND_M = 1.0
"""A point touches a car if it is in its box grown by this on all sides [m]."""
SEEDS = (1, 2, 3)


@dataclass(frozen=True)
class Row:
    """One run of the scenario: which kinds of noise are on, all at the strengths that are default."""

    name: str
    kinds: tuple[str, ...]
    seed: int = 1

    def scenario(self) -> Scenario:
        """Return the scenario of the run."""
        noise = {kind: {"enabled": kind in self.kinds} for kind in KINDS}
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


def main() -> None:
    """Run all, then write the page and the picture."""
    runs = {row: fit_errors(row) for row in dict.fromkeys([NONE, *ALONE, *TOGETHER, *ON_BASE, *OTHER_SEEDS])}
    means = pd.DataFrame({row: errors.mean() for row, errors in runs.items()}).T
    observations = {row: len(errors) for row, errors in runs.items()}
    touched = [touched_row(row, runs[row], runs[NONE]) for row in ALONE if row.name in CAUSE_OF]
    text = PAGE.read_text(encoding="utf-8")
    for name, rows in (("alone", [NONE, *ALONE, *TOGETHER]), ("base", ON_BASE), ("seeds", OTHER_SEEDS)):
        text = written(text, name, error_table(rows, means, observations))
    PAGE.write_text(written(text, "touched", touched_table(touched)), encoding="utf-8")
    draw(means.loc[[NONE, *ALONE, *TOGETHER]])


def fit_errors(row: Row) -> pd.DataFrame:
    """Absolute heading errors [deg] of a run: a row per observation (frame, actor), a column per criterion."""
    print(row.name, file=sys.stderr, flush=True)
    fits = loop.run(row.scenario(), device.load(device.SHIPPED)).tables["fits"]
    fits = fits.assign(error=fits["heading_error_deg"].abs())
    best = fits[fits["best"]].assign(method="best")
    both = pd.concat([fits.astype({"method": str}), best])[["frame", "actor_id", "method", "error"]]
    return both.pivot_table(index=["frame", "actor_id"], columns="method", values="error")[[*CRITERIA]]


def points_near_cars(row: Row, cause: Cause) -> pd.Series:
    """How many points of a cause lie on or near each car, by (frame, actor); the sensor alone is run for it."""
    scenario = row.scenario()
    rig = load_rig(str(scenario.rig), scenario.folder)
    source = ScriptedSource(scenario.traffic, scenario.folder, range_m=200.0)
    lidar = Lidar(rig, scenario.noise, scenario.sensor, scenario.seed, source.reset(scenario.seed))
    counts = {}
    for _ in range(round(scenario.duration_s / source.dt)):
        frame = source.step()
        scan, truth = lidar.scan(frame)
        points = scan.points_ego[truth.cause == cause, :2]  # the ego of the ring stands at the world's origin
        for actor, pose, size in zip(frame.actors.id, frame.actors.pose_world, frame.actors.size, strict=True):
            turn = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
            near = np.abs((points - pose[:2]) @ turn) < 0.5 * size[:2] + AROUND_M
            counts[frame.index, int(actor)] = int(near.all(axis=1).sum())
    return pd.Series(counts)


def touched_row(row: Row, with_it: pd.DataFrame, without: pd.DataFrame) -> list[str]:
    """Cells of the table of touched observations: those that hold points of the kind's own cause."""
    counts = points_near_cars(row, CAUSE_OF[row.name])
    both = with_it.index.intersection(without.index)
    near = counts.reindex(both)
    touched = both[near.to_numpy() > 0]
    cells = [f"`{row.name}`", f"{near.mean():.3g}", f"{len(touched) / len(both):.1%}"]
    for criterion in CRITERIA:
        before, after = without.loc[touched, criterion].mean(), with_it.loc[touched, criterion].mean()
        cells.append(f"{before:.2f} → {after:.2f}")
    return cells


def touched_table(rows: list[list[str]]) -> str:
    """Markdown: how the error changes where a kind of noise has points of its own."""
    head = ["noise alone", "its points a car", "cars touched", *CRITERIA.values()]
    return as_markdown(head, rows)


def error_table(rows: list[Row], means: pd.DataFrame, observations: dict[Row, int]) -> str:
    """Markdown: mean absolute heading error [deg] by criterion."""
    cells = []
    for row in rows:
        name = f"`{row.name}`" if row.name in KINDS else row.name
        cells.append([name, *(f"{means.loc[row, criterion]:.3f}" for criterion in CRITERIA), str(observations[row])])
    return as_markdown(["noise", *CRITERIA.values(), "observations"], cells)


def as_markdown(head: list[str], rows: Iterable[list[str]]) -> str:
    """A Markdown table, numbers to the right."""
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def written(text: str, name: str, table: str) -> str:
    """Return a page with the block of this name written anew."""
    pattern = rf"(<!-- {name} -->\n).*?(<!-- end -->)"
    return re.sub(pattern, lambda match: match[1] + table + match[2], text, flags=re.DOTALL)


def draw(means: pd.DataFrame) -> None:
    """Draw the errors as bars: a panel per criterion, a bar per run, a line where no noise is."""
    names = [row.name.partition(":")[0].replace("_", " ") for row in means.index]
    place = np.arange(len(means))[::-1] - 0.5 * np.array([row in TOGETHER for row in means.index])
    figure, panels = plt.subplots(1, len(CRITERIA), figsize=(11, 5.2), sharey=True, layout="constrained")
    for axes, (criterion, title) in zip(panels, CRITERIA.items(), strict=True):
        values, without = means[criterion], means.loc[NONE, criterion]
        worse = values.to_numpy() > 1.05 * without
        colors = np.where(worse, "tab:red", np.where(values.to_numpy() < 0.95 * without, "tab:blue", "0.6"))
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
        "Ring scenario, one kind of noise at a time (red: over 5 % worse than with none, blue: over 5 % better)",
        fontsize=10,
    )
    figure.savefig(PICTURE, dpi=90)
    plt.close(figure)


if __name__ == "__main__":
    main()
