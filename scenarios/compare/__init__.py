"""Two sets of runs held against each other: what changed, what failed, and what is only chance."""
