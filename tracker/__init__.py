"""The device under test: the tracker of "Low-cost LIDAR based Vehicle Pose Estimation and Tracking".

It knows nothing of simulation: give it `Scan`s of a real rig and it runs unchanged.
"""
