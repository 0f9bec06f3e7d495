"""Candidates for the ego: how long each vehicle of some traffic stays, and what happens around it."""
