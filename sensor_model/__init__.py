"""Synthetic LIDAR rig: units, ray caster, noise, and ground truth of every beam."""
