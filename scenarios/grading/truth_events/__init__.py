"""Events of the ground truth that real traffic does not have, found in the frames of a run, without the tracker."""
