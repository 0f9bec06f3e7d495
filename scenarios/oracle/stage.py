"""Stages that have an oracle, and the names of oracles. Imported by the command line, so without heavy imports."""

from enum import StrEnum

ORACLE = "oracle: "
"""Start of the name of every device with the ground truth that a user can choose; comparisons refuse its results."""


class Stage(StrEnum):
    """Stages of the shipped tracker that an oracle can replace, in processing order."""

    SEGMENTATION = "segmentation"
    OUTLIERS = "outliers"
    FIT = "fit"
    ASSOCIATION = "association"
    MODEL = "model"
    SIZE = "size"
    CONFIRMATION = "confirmation"
