"""Reports as HTML: one self-contained page of a run or of a suite, without scripts and without anything to fetch."""
