"""Roads of OpenDRIVE files: reference lines, lanes and links."""
