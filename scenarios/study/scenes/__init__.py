"""Scenes for studies: functions that return a scenario document for some parameters."""
