"""Traffic by OpenSCENARIO 1.x files: a storyboard moves entities along the lanes of an OpenDRIVE file."""
