"""Files of scenarios, and how files are read and written."""
