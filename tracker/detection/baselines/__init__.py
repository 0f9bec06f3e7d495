"""What the paper sets itself against: other ways to a heading, measured beside its own and never selected.

One file each, with a function `heading(points_ego, config)` of the form `columns.Baseline`.
"""
