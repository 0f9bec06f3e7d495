"""Kinds of road users guessed from the names of types in a recording."""

from collections.abc import Iterator, Mapping

from luxloop.sim.replay.recording import KIND_BY_NAME, ReplayType
from luxloop.sim.scripted.script import KindName

WORDS: dict[str, KindName] = {
    "semi": "trailer-truck",
    "trailer": "trailer-truck",
    "motorcycle": "motorcycle",
    "motorbike": "motorcycle",
    "moped": "motorcycle",
    "bicycle": "bicycle",
    "bike": "bicycle",
    "cyclist": "bicycle",
    "ped": "pedestrian",
    "person": "pedestrian",
    "bus": "bus",
    "coach": "bus",
    "tram": "bus",
    "rail": "bus",
    "train": "bus",
    "truck": "truck",
    "lorry": "truck",
    "delivery": "van",
    "van": "van",
    "emergency": "van",
}
"""Kind by a part of a type's name; the first match counts. Other types are cars."""


class TypeGuesses(Mapping[str, ReplayType]):
    """Mapping from any unknown type to a guess; it remembers the guesses."""

    def __init__(self) -> None:
        self.made: dict[str, ReplayType] = {}

    def __contains__(self, word: object) -> bool:
        """Return True for names that are neither kinds nor SUMO's built-in types."""
        return isinstance(word, str) and word not in KIND_BY_NAME and not word.startswith("DEFAULT_")

    def __getitem__(self, word: str) -> ReplayType:
        if word not in self.made:
            kind: KindName = next((kind for part, kind in WORDS.items() if part in word.lower()), "car")
            self.made[word] = ReplayType(kind)
        return self.made[word]

    def __iter__(self) -> Iterator[str]:
        return iter(self.made)

    def __len__(self) -> int:
        return len(self.made)
