"""Oracles: the shipped tracker with the truth in the place of one stage, or of several.

What a metric gains by it is what the stage costs: no better stage can gain more, where the stages after it are as they
are. Mind what that leaves out:

- A later stage's truth hides what earlier ones did to it. A true fit needs no outlier removal; gains do not add up.
- Stages after an oracle were tuned to the real stage's mistakes. A truer input may cost them something: a gain may be
  negative.
- What is no stage here is nobody's: preprocessing, the sweep's correction, belief in tracks, their sizes and their end.
- The truth knows actors. On walls and on nothing every stage goes on as it is.

Each stage's file says what its truth is. Nothing of this is known in `tracker/`: its classes are subclassed from here.
"""
