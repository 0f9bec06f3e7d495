"""Synthetic LIDAR rig: units, ray caster, noise, and ground truth of every beam."""

if not __name__.startswith("luxloop."):
    raise ImportError("sensor_model is luxloop.sensor_model: change the import to that name", name=__name__)
