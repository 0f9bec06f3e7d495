"""The stages that have an oracle. Light to import: the command line offers them."""

from enum import StrEnum


class Stage(StrEnum):
    """A stage of the shipped tracker that the truth can replace, in the order of the data."""

    SEGMENTATION = "segmentation"
    OUTLIERS = "outliers"
    FIT = "fit"
    ASSOCIATION = "association"
    MODEL = "model"
