"""The two files of a grading."""

from typing import Literal

Role = Literal["truth", "tracks"]
