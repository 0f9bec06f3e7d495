"""Scene: a wall hides a moving car while a LIDAR is silent."""

from luxloop.scenarios.study.scenes.hidden_behind_wall import Manoeuvre, hidden_behind_wall
from luxloop.scenarios.study.scenes.scene_parts import BEFORE_S, Json, scene_rig

NO_OTHER_OUTAGE_S = 1e9


def hidden_with_failed_unit(
    unit: str, occlusion_s: float, speed_mps: float = 10.0, manoeuvre: Manoeuvre = "keeps speed"
) -> Json:
    """Return the scene `hidden_behind_wall`, in which a unit fails one second before the car is hidden.

    The wall stays as long as with all units, so the car is hidden for the same time; it is lost earlier and reappears
    later if the failed unit would have seen it first.

    Parameters
    ----------
    unit
        Name of the unit in the rig, e.g. `side left`; `none` for the same scene without a failure.
    occlusion_s, speed_mps, manoeuvre
        As for `hidden_behind_wall`.

    Raises
    ------
    ValueError
        The rig has no such unit, or as for `hidden_behind_wall`.
    """
    scene = hidden_behind_wall(occlusion_s, speed_mps, manoeuvre)
    if unit == "none":
        return scene
    names = [mount.name for mount in scene_rig().mounts]
    if unit not in names:
        raise ValueError(f'unit = "{unit}": should be {", ".join(names)} or none')
    fixed = {"unit": unit, "from_s": BEFORE_S - 1.0, "to_s": NO_OTHER_OUTAGE_S}
    outage = {"enabled": True, "mean_uptime_s": NO_OTHER_OUTAGE_S, "fixed": [fixed]}
    return {**scene, "noise": {"outage": outage}}
