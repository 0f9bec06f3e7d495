"""The synthetic rig: six four-layer LIDARs, their noise, and the truth of every beam."""
