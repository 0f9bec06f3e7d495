"""`--truth`: the vehicle whose poses a topic gives, and its box about these poses."""

from dataclasses import dataclass

import numpy as np

from luxloop.scenarios.arrays import Floats
from luxloop.scenarios.errors import InputError

HEIGHT_M = 1.5
"""[m] Height of a box whose height is not given, of a passenger car."""


@dataclass(frozen=True, slots=True)
class TruthOption:
    """A vehicle with recorded poses. Lengths are in the units of the recording."""

    topic: str
    length_m: float
    width_m: float
    x_m: float = 0.0
    """Centre of the box in the frame of the poses, ahead [m]."""
    y_m: float = 0.0
    """The same, to the left [m]."""
    height_m: float = HEIGHT_M

    @classmethod
    def parse(cls, text: str) -> "TruthOption":
        """Read `TOPIC=LENGTH,WIDTH[,X,Y[,HEIGHT]]`.

        Raises
        ------
        InputError
            The text is of another form, or a side is not positive.
        """
        topic, _, rest = text.rpartition("=")
        try:
            numbers = [float(part) for part in rest.split(",")]
        except ValueError:
            numbers = []
        if not topic or len(numbers) not in (2, 4, 5) or not np.isfinite(numbers).all() or min(numbers[:2]) <= 0.0:
            raise InputError(
                f"--truth {text}: should be TOPIC=LENGTH,WIDTH or TOPIC=LENGTH,WIDTH,X,Y[,HEIGHT] in metres"
            )
        return cls(topic, *numbers)

    @property
    def name(self) -> str:
        """Name of the vehicle: the topic without its slash."""
        return self.topic.strip("/")

    def centres(self, rows: Floats) -> Floats:
        """Return time, x, y, yaw (M, 4) of the box centre, from those of the poses (M, 4)."""
        cos, sin = np.cos(rows[:, 3]), np.sin(rows[:, 3])
        moved = rows.copy()
        moved[:, 1] += cos * self.x_m - sin * self.y_m
        moved[:, 2] += sin * self.x_m + cos * self.y_m
        return moved
