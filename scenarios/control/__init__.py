"""Closed loop: a cruise controller drives the ego on the tracks, and in a second drive on the ground truth."""
