"""Oracles: the shipped tracker with the truth in the place of one stage, or of several.

What a metric gains by it is what the stage costs, given the others as they are. Mind what that means:

- A metric that grades a stage itself becomes ideal by the stage's own truth; what it costs shows in the tracks.
- A later stage's truth hides what earlier ones did to it: a true fit needs no outlier removal. Gains do not add up.
- The stages after an oracle were tuned to the real stage's mistakes, and some of these happen to make up for others: a
  gain may be negative.
- A segment that holds parts of two vehicles is the one's that owns most of it. Fit, association and model take it so.
- What is no stage here is nobody's: preprocessing, the sweep's correction, belief in tracks, their sizes and their end.
- The truth knows actors. On walls and on nothing every stage goes on as it is.

Each stage's file says what its truth is. Nothing of this is known in `tracker/`: its classes are subclassed from here.
"""
