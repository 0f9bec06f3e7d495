"""Realism: statistics of simulated vehicles beside those of real ones, matched by range, aspect and end seen.

The statistics are functions of the points of one vehicle, its labelled box and the position of the LIDAR, so that they
can be computed for any labelled recording.
"""
