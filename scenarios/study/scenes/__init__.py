"""Scenes for studies, generated from parameters."""
