"""Baselines: other heading estimators, for comparison only.

One file each, with a function `heading(points_ego, config)` of the type `columns.Baseline`.
"""
