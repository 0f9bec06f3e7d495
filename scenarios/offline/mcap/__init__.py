"""MCAP export of recorded scans, ground truth and tracks for ROS 2 tools and Foxglove; ROS is not required."""
