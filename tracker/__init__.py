"""The device under test: the tracker of "Low-cost LIDAR based Vehicle Pose Estimation and Tracking".

It does not depend on the simulation and runs unchanged on `Scan`s of a real rig.
"""

if not __name__.startswith("luxloop."):
    raise ImportError("tracker is luxloop.tracker: change the import to that name", name=__name__)
