"""Recorded scans, their truth and the tracks as MCAP, for tools of ROS 2 and Foxglove; ROS itself is not needed."""
