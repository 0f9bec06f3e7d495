"""Adapters of the league's trackers, one file each; only they import Stone Soup and norfair, when they are made."""
