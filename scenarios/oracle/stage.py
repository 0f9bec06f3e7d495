"""Stages that have an oracle. Imported by the command line, so without heavy imports."""

from enum import StrEnum


class Stage(StrEnum):
    """Stages of the shipped tracker that an oracle can replace, in processing order."""

    SEGMENTATION = "segmentation"
    OUTLIERS = "outliers"
    FIT = "fit"
    ASSOCIATION = "association"
    MODEL = "model"
    CONFIRMATION = "confirmation"
