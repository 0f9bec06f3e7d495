"""Kernels of tracking, one file per stage: plain arrays in and out, no config, no random state.

Vectors are in the odometry frame; tracks are the first axis of an array, boxes the second, motion models the next.
"""
