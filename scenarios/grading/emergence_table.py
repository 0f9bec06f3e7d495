"""Table of emergence: a row per actor and stage, with the situation when it is reached, or at the end if it is not."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.meeting_point import EgoPath
from luxloop.scenarios.grading.time_to_collision import time_to_collision
from luxloop.scenarios.metrics.definitions import STAGES
from luxloop.sim.world import Kind

COLUMNS = (
    "actor_id", "name", "kind", "stage", "reached", "frame", "time_s",
    "delay_s", "range_m", "ttc_s", "meeting_m", "meeting_s",
)  # fmt: skip

BOX = ["x_world_m", "y_world_m", "yaw_world_rad", "length_m", "width_m"]
VELOCITY = ["vx_world_mps", "vy_world_mps"]


def emergence_table(first: Mapping[str, Mapping[int, int]], truth: pd.DataFrame, ego: pd.DataFrame) -> pd.DataFrame:
    """Return the table `emergence` of a run.

    Parameters
    ----------
    first
        First frame of each stage by actor id, see `EmergenceLog.first`.
    truth, ego
        Tables of the run.

    Returns
    -------
    DataFrame
        `COLUMNS`. A stage that is not `reached` has the values of the last frame with the actor: it is censored there.
        `delay_s` is NaN for an actor without any beam, the time to collision infinite without a collision course,
        `meeting_m` and `meeting_s` NaN without a meeting point and negative beyond it.
    """
    moments = _moments(first, truth)
    at = moments.merge(truth[["frame", "actor_id", "time_s", "range_m", *BOX, *VELOCITY]], on=["frame", "actor_id"])
    now = ego.set_index("frame").loc[at["frame"]].reset_index()
    path = EgoPath.of(ego["time_s"].to_numpy(), _boxes(ego)) if len(ego) else None
    meeting = {
        actor: path.meeting(_boxes(rows), float(np.hypot(*_velocities(rows)[-1])))
        for actor, rows in truth[_is_traffic(truth)].groupby("actor_id")
        if path
    }
    time_s, along_m = np.array([meeting[actor] for actor in at["actor_id"]]).reshape(-1, 2).T
    driven = pd.Series(path.along_m if path else [], ego["frame"], dtype=np.float64)
    at["delay_s"] = at["time_s"] - at["actor_id"].map(_first_beams(at))
    at["ttc_s"] = time_to_collision(_boxes(now), _velocities(now), _boxes(at), _velocities(at))
    at["meeting_m"] = along_m - at["frame"].map(driven).to_numpy()
    at["meeting_s"] = time_s - at["time_s"]
    return at[list(COLUMNS)]


def _moments(first: Mapping[str, Mapping[int, int]], truth: pd.DataFrame) -> pd.DataFrame:
    """Return `actor_id`, `name`, `kind`, `stage`, `reached` and `frame`, a row per actor and stage."""
    last = truth[_is_traffic(truth)].drop_duplicates("actor_id", keep="last").sort_values("actor_id")
    moments = last[["actor_id", "name", "kind", "frame"]].merge(
        pd.DataFrame({"stage": pd.Categorical(list(STAGES), list(STAGES))}), how="cross"
    )
    reached = [first[stage].get(actor, -1) for actor, stage in zip(moments["actor_id"], moments["stage"], strict=True)]
    frame = np.array(reached, dtype=np.int64)
    return moments.assign(reached=frame >= 0, frame=np.where(frame >= 0, frame, moments["frame"]))


def _first_beams(at: pd.DataFrame) -> pd.Series:
    beam = at[(at["stage"] == "first_beam") & at["reached"]]
    return beam.set_index("actor_id")["time_s"]


def _is_traffic(truth: pd.DataFrame) -> pd.Series:
    return truth["kind"] != Kind.OBSTACLE.name.lower()


def _boxes(rows: pd.DataFrame) -> Floats:
    return np.asarray(rows[BOX], np.float64)


def _velocities(rows: pd.DataFrame) -> Floats:
    return np.asarray(rows[VELOCITY], np.float64)
