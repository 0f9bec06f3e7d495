"""Reports as HTML: one self-contained page of a run or a suite, without scripts and external resources."""
