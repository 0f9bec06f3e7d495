"""Simulation-in-the-loop testbed for low-cost LIDAR vehicle tracking."""
