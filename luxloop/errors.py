"""The base class of every error that a user can correct."""


class Error(Exception):
    """A request that cannot be carried out. The message is one line: place, key, wrong value, remedy."""
