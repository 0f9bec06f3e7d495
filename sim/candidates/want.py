"""Property by which candidates for the ego are ordered. Fast to import, for the command line."""

from enum import StrEnum


class Want(StrEnum):
    """Property that the best candidate has most of."""

    NEIGHBOURS = "neighbours"
    TURNS = "turns"
    STOPS = "stops"
    OCCLUSION = "occlusion"
    LONG = "long"
