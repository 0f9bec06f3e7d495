"""Plug-ins for luxloop: traffic on a circle, files of laps, and a tracker of patches."""
