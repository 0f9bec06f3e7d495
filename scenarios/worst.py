"""The frames that a metric is worst in: where to look first."""

from collections.abc import Mapping
from typing import NamedTuple

import pandas as pd

<<<<<<< HEAD
from scenarios.grading.snapshots import PATIENCE_S
from scenarios.result import Result

NEWCOMER = 0.01
"""What a vehicle without a track counts that came into view less than `PATIENCE_S` ago: tracks take time to confirm."""
=======
from scenarios import badness
from scenarios.badness import Rated
from scenarios.grading.metrics import DRIVERS
from scenarios.result import Result

_IDENTITIES = ("id_switches", "id_switches_in_view", "fragments", "occlusion_survival", "hidden_2s_survival")
_MODES = ("mode_accuracy", "stationary_accuracy", "confusion", "switch_latency_frames")
>>>>>>> main


class WorstFrame(NamedTuple):
    """One frame to look at."""

    frame: int
    time_s: float
    what: str

    def __str__(self) -> str:
        return f"frame {self.frame} ({self.time_s:.2f} s): {self.what}"


def worst_frames(result: Result, metric: str, count: int = 3) -> list[WorstFrame]:
    """Return up to `count` frames in which a metric is worst, the worst first.

    There are none of a metric without a value, and of one that tells nothing of single frames: of data set and time.
    """
    known = result.metrics.get(metric)
    rated = _rated(result.tables, metric) if known and known.value is not None else None
    if rated is None:
        return []
    rows = rated.rows.assign(badness=rated.badness.fillna(0.0))
    bad = rows[rows["badness"] > 0].sort_values(["badness", "frame"], ascending=[False, True], kind="stable")
    worst = bad.drop_duplicates("frame").head(count)
    return [WorstFrame(row["frame"], row["time_s"], rated.tell(row)) for row in worst.to_dict("records")]


<<<<<<< HEAD
def _badness(tables: dict[str, pd.DataFrame], metric: str) -> pd.DataFrame | None:
    """Rows of `frame`, `time_s`, `badness` (the larger the worse, 0 is none) and `what` was wrong, in words."""
    family = metric.split(".")[0]
    if family == "fit":
        return _fits(tables["fits"], metric.split(".")[-2])
    if family == "mma":
        return _positions(tables["tracks"])
    if family == "segmentation":
        return _segments(tables["truth"])
    if family == "outliers":
        return _outliers(tables["outliers"], metric.split(".")[1])
    if family == "control":
        return _control(tables.get("control"))
    if metric.startswith("track.heading"):
        return _headings(tables["tracks"])
    if metric in ("track.id_switches", "track.id_switches_in_view", "track.fragments") or "survival" in metric:
        return _identities(tables["truth"])
    return _detections(tables["truth"], tables["tracks"]) if family == "track" else None


def _of(table: pd.DataFrame, badness: pd.Series, tell: Callable[[pd.Series], str]) -> pd.DataFrame:
    """Judge the rows of a table; words are found for the worst only, as they take long."""
    rated = table.assign(badness=badness.fillna(0.0))
    worst = rated.sort_values("badness", ascending=False, kind="stable").head(64)
    what = [tell(row) for _, row in worst.iterrows()]
    return worst[["frame", "time_s", "badness"]].assign(what=what)


def _fits(fits: pd.DataFrame, method: str) -> pd.DataFrame:
    chosen = fits[fits[method]] if method in ("best", "oracle") else fits[fits["method"] == method]

    def tell(row: pd.Series) -> str:
        name, view, place = row["method"], row["view"].replace("_", " "), f"at {row['range_m']:.0f} m"
        return f"{name} is {row['heading_error_deg']:+.1f} deg off on vehicle {row['actor_id']}, {view} {place}"

    return _of(chosen, chosen["heading_error_deg"].abs(), tell)


def _positions(tracks: pd.DataFrame) -> pd.DataFrame:
    judged = tracks[tracks["judged"]]
    error = np.hypot(judged["mma_x_error_m"], judged["mma_y_error_m"])

    def tell(row: pd.Series) -> str:
        return f"track {row['track_id']} on vehicle {row['actor_id']} is {row['badness']:.2f} m off, by {row['model']}"

    return _of(judged, error, tell)


def _headings(tracks: pd.DataFrame) -> pd.DataFrame:
    judged = tracks[tracks["judged"]]

    def tell(row: pd.Series) -> str:
        return f"track {row['track_id']} on vehicle {row['actor_id']} points {row['heading_error_deg']:+.1f} deg off"

    return _of(judged, judged["heading_error_deg"].abs(), tell)


def _segments(truth: pd.DataFrame) -> pd.DataFrame:
    graded = truth[truth["graded"]]

    def tell(row: pd.Series) -> str:
        share = row["largest_segment_share"]
        return f"{share:.0%} of vehicle {row['actor_id']}'s {row['points']} points are in its largest segment"

    return _of(graded, 1.0 - graded["largest_segment_share"], tell)


def _outliers(outliers: pd.DataFrame, cause: str) -> pd.DataFrame:
    of_cause = outliers[outliers["cause"] == cause]

    def tell(row: pd.Series) -> str:
        return f"{row['removed']} of {row['points']} removed, and {row['clean_removed_beside']} clean points with them"

    return _of(of_cause, of_cause["points"] - of_cause["removed"] + of_cause["clean_removed_beside"], tell)


def _control(control: pd.DataFrame | None) -> pd.DataFrame | None:
    if control is None:
        return None

    def tell(row: pd.Series) -> str:
        return f"{row['ttc_s']:.2f} s to a collision, {row['gap_m']:.1f} m away, driven by the {row['driver']}"

    return _of(control, 1.0 / control["ttc_s"].clip(lower=1e-3), tell)


def _identities(truth: pd.DataFrame) -> pd.DataFrame:
    """Frames in which a vehicle is followed by another track than when it was last followed."""
    followed = truth[truth["graded"] & (truth["track_id"] >= 0)].sort_values("frame", kind="stable")
    before = followed.groupby("actor_id")["track_id"].shift()
    changed = before.notna() & (before != followed["track_id"])

    def tell(row: pd.Series) -> str:
        return f"vehicle {row['actor_id']} goes from track {row['before']:.0f} to track {row['track_id']}"

    return _of(followed.assign(before=before), changed.astype(float), tell)


def _detections(truth: pd.DataFrame, tracks: pd.DataFrame) -> pd.DataFrame:
    """Graded vehicles without a track and tracks on nothing, by frame; newcomers without one weigh little."""
    graded = truth[truth["graded"]]
    age_s = graded["time_s"] - graded.groupby("actor_id")["time_s"].transform("min")
    lost = graded.assign(weight=np.where(age_s < PATIENCE_S, NEWCOMER, 1.0))[graded["track_id"] < 0]
    by_frame = lost.groupby("frame")["weight"]
    columns = {
        "missed": by_frame.size(),
        "weight": by_frame.sum(),
        "false": tracks[tracks["verdict"] == "false"].groupby("frame").size(),
    }
    frames = truth[["frame", "time_s"]].drop_duplicates()
    frames = frames.assign(**{name: frames["frame"].map(column).fillna(0) for name, column in columns.items()})

    def tell(row: pd.Series) -> str:
        return f"{row['missed']:.0f} graded vehicles without a track, {row['false']:.0f} tracks on nothing"

    return _of(frames, frames["weight"] + frames["false"], tell)
=======
def _rated(tables: Mapping[str, pd.DataFrame], metric: str) -> Rated | None:
    """Choose the rows that a metric is made of, and how bad each is, by the metric's name."""
    match metric.split("."):
        case ["fit", *view, method, measure]:
            return badness.fits(tables["fits"], view, method, measure)
        case ["mma", measure, *_] if measure in _MODES:
            return badness.modes(tables["tracks"], standing_only=measure == "stationary_accuracy")
        case ["mma", *model, measure] if measure.startswith(("nees", "nis")):
            return badness.consistency(tables["tracks"], "_".join([*model, measure.partition("_")[0]]))
        case ["mma", "gain", target]:
            return badness.positions(tables["tracks"], "mma", target, "xy")
        case ["mma", estimate, target, measure]:
            return badness.positions(tables["tracks"], estimate, target, measure[0])
        case ["segmentation", "under_rate"]:
            return badness.merged(tables["segments"])
        case ["segmentation", _]:
            return badness.split(tables["truth"])
        case ["outliers", cause, _]:
            return badness.outliers(tables["outliers"], cause)
        case ["control", measure]:
            driver = "truth" if measure.startswith(DRIVERS["truth"]) else "tracks"
            return badness.control(tables["control"], driver, measure.removeprefix(DRIVERS[driver]))
        case ["track", measure] if measure.startswith("heading"):
            return badness.headings(tables["tracks"])
        case ["track", measure] if measure in _IDENTITIES:
            return badness.identities(tables["truth"])
        case ["track", "loca"]:
            return badness.overlaps(tables["tracks"])
        case ["track", _]:
            return badness.detections(tables["truth"], tables["tracks"])
    return None
>>>>>>> main
