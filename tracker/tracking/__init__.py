"""Tracking: boxes to tracks."""
