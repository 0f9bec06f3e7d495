"""Physical truth layer: feasible motions from the poses of a traffic simulator."""
