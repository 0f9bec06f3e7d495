"""Actors and tracks of a frame as boxes of a Foxglove scene.

The metadata of a box has its exact numbers as text, since a quaternion rounds the heading: `heading_rad` in the true
ego frame, and the pose and velocity over ground in the world frame. `luxloop.scenarios.offline.mcap.boxes` reads them.
"""

import numpy as np
import pandas as pd

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.grading.ownership import points_of_actors
from luxloop.scenarios.grading.plane_geometry import into_frame
from luxloop.scenarios.offline.mcap.messages import Box, Color
from luxloop.sensor_model.truth import ScanTruth
from luxloop.sim.world import Kind, WorldFrame

TRACK_HEIGHT_M = 1.5
"""Height of track boxes; tracks have no height."""
TRUTH: Color = (1.0, 1.0, 1.0, 0.3)
COLORS: dict[str, Color] = {
    "tentative": (0.6, 0.6, 0.6, 0.3),
    "confirmed": (0.2, 0.8, 0.4, 0.5),
    "coasting": (0.3, 0.5, 1.0, 0.4),
}
"""Colour of tracks by status; dead tracks are not exported."""
POINTS = "points"
"""Key of the number of points on an actor."""
HEADING = "heading_rad"
WORLD = ("x_world_m", "y_world_m", "heading_world_rad", "vx_world_mps", "vy_world_mps")
"""Keys of the exact numbers."""
POSE, VELOCITY = ["x_world_m", "y_world_m", "yaw_world_rad"], ["vx_world_mps", "vy_world_mps"]
"""Columns of the table of tracks."""


def actor_boxes(frame: WorldFrame, truth: ScanTruth) -> list[Box]:
    """Return the boxes of all actors."""
    actors, fraction = frame.actors, truth.visible_fraction
    points = points_of_actors(truth.actor_id, actors.id)
    pose_ego = into_frame(actors.pose_world, frame.ego.pose_world)
    return [
        Box(
            id=f"actor {actors.id[a]}",
            pose_ego=pose_ego[a],
            size=actors.size[a],
            color=TRUTH,
            label=str(actors.name[a]),
            metadata={
                "name": actors.name[a],
                "kind": Kind(actors.kind[a]).name.lower(),
                "visible_fraction": f"{fraction[a]:.3f}",
                POINTS: str(points[a]),
                **_exact(pose_ego[a], actors.pose_world[a], actors.velocity_world[a]),
            },
        )
        for a in range(len(actors))
    ]


def track_boxes(frame: WorldFrame, tracks: pd.DataFrame) -> list[Box]:
    """Return boxes in the true ego frame: the tables hold track poses without the odometry drift."""
    shown = tracks[tracks["status"].isin(list(COLORS))]
    pose_world, velocity = (shown[columns].to_numpy(np.float64) for columns in (POSE, VELOCITY))
    pose_ego = into_frame(pose_world, frame.ego.pose_world)
    return [
        Box(
            id=f"track {row.track_id}",
            pose_ego=pose_ego[t],
            size=np.array([row.length_m, row.width_m, TRACK_HEIGHT_M]),
            color=COLORS[row.status],
            label=f"{row.track_id}",
            metadata={
                "status": row.status,
                "verdict": row.verdict,
                "actor_id": row.actor_id,
                **_exact(pose_ego[t], pose_world[t], velocity[t]),
            },
        )
        for t, row in enumerate(shown.itertuples())
    ]


def _exact(pose_ego: Floats, pose_world: Floats, velocity_world: Floats) -> dict[str, str]:
    """Return numbers as the shortest texts that give the same float64."""
    values = zip(WORLD, [*pose_world.tolist(), *velocity_world.tolist()], strict=True)
    return {HEADING: repr(float(pose_ego[2])), **{key: repr(value) for key, value in values}}
