"""Every limit of grading, in one place, printed with every result."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class GradingConfig:
    """What counts, and when."""

    range_max_m: float = 50.0
    """[m] from the ego's centre to the vehicle's; beyond it nothing is graded, tracks on nothing included."""
    points_min: int = 10
    """Scan points of its own that a vehicle needs to be graded in a frame."""
    bent_deg: float = 5.0
    """An articulated truck that is bent by more is not graded in that frame: no rectangle describes it. At 5 degrees,
    the smallest one around it is 1.4 degrees off its trailer, as much as good fits are off anyway."""
    memory_s: float = 3.0
    """[s] that a graded vehicle stays in the books once it is hidden."""
    hidden_fraction_max: float = 0.1
    """A vehicle that shows no more than this fraction of itself in a gap of its grading was occluded in it."""
    match_iou_min: float = 0.1
    """Bird's-eye overlap from which a track follows an actor. Low: it only says who is meant; a track that sees
    just the rear of a long truck still means it. How well it fits is for HOTA and CLEAR to say."""
    hit_iou_min: float = 0.5
    """Overlap from which CLEAR and Identity count a hit (trackeval's default)."""
    owner_share_min: float = 0.5
    """A segment belongs to a vehicle that owns more than this share of its points."""
    part_share_min: float = 0.2
    """From this share of the points on, a part of a vehicle (or of a segment) is worth counting."""
    nees_confidence: float = 0.95
    """Probability of the two-sided chi-square band that holds a consistent filter's position error."""

    def __post_init__(self) -> None:
        for name in ("range_max_m", "bent_deg", "memory_s"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} = {getattr(self, name)} must be positive")
        if self.points_min < 1:
            raise ValueError(f"points_min = {self.points_min} must be 1 or more: an unseen vehicle cannot be graded")
        for name in ("match_iou_min", "hit_iou_min", "nees_confidence", "part_share_min"):
            if not 0 < getattr(self, name) < 1:
                raise ValueError(f"{name} = {getattr(self, name)} must lie between 0 and 1")
        if not 0.5 <= self.owner_share_min < 1:
            raise ValueError(
                f"owner_share_min = {self.owner_share_min} must be 0.5 or more and below 1, "
                "or a segment could have two owners"
            )
        if not 0 <= self.hidden_fraction_max < 1:
            raise ValueError(f"hidden_fraction_max = {self.hidden_fraction_max} must be 0 or more and below 1")
