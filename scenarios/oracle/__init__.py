"""Oracles: the shipped tracker with ground truth in place of one or several stages.

The gain of a metric by an oracle is the cost of that stage, given the other stages. Interpretation:

- A metric that grades a stage is ideal with the oracle of that stage; the cost of the stage shows in the tracks.
- The oracle of a later stage hides errors of earlier ones: a true fit needs no outlier removal. Gains do not add up.
- The stages after an oracle were tuned to the errors of the real stage, and some errors compensate others: a gain may
  be negative.
- A segment with parts of two vehicles belongs to the owner of most of it, in the oracles of fit, association and model.
- Some parts of the tracker have no oracle: preprocessing, deskewing, termination.
- Ground truth covers actors. Points on walls and clutter are processed by the real stages.

The file of each stage documents its ground truth. `tracker/` does not know about oracles: they are objects passed to
`Tracker`.
"""
