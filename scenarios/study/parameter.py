"""One parameter of a study: a key of the scenario, and the values it takes."""

from typing import Annotated, Literal, Self, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

Value = float | int | str | bool
T = TypeVar("T")


def distinct(values: list[T]) -> list[T]:
    """Refuse to run the same twice."""
    if not values:
        raise ValueError("give one at least")
    if len(set(values)) < len(values):
        raise ValueError(f"{values}: something stands in it twice; take it out once")
    return values


class Strict(BaseModel):
    """Forbids what it does not know."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


class Vary(Strict):
    """One parameter."""

    key: str
    """A key of the scenario file, as `noise.dropout.random_rate` or `traffic.actor[truck].x_m`; of a staged scene, the
    name of one of its parameters."""
    values: Annotated[list[Value], AfterValidator(distinct)] | None = None
    """The values it takes; else a range."""
    low: float | None = None
    """Lower end of the range."""
    high: float | None = None
    """Upper end of the range."""
    steps: Annotated[int, Field(ge=2)] | None = None
    """Values on the range, both ends included; a study with `samples` draws from all of it instead."""
    scale: Literal["linear", "log"] = "linear"
    """How the range is divided, or drawn from."""
    label: str = ""
    """What the axis of a picture says, with the unit; the key if left out."""
    neutral: Value | None = None
    """Its value where nothing is disturbed; a search needs it."""

    @model_validator(mode="after")
    def _values_or_a_range(self) -> Self:
        if self.values is not None:
            if (self.low, self.high, self.steps) != (None, None, None):
                raise ValueError("give values, or low and high of a range, not both")
        elif self.low is None or self.high is None or self.low >= self.high:
            raise ValueError("give values, or a range: low below high")
        elif self.scale == "log" and self.low <= 0:
            raise ValueError(f"low = {self.low:g}: a logarithmic range starts above 0")
        return self

    @model_validator(mode="after")
    def _neutral_is_among_them(self) -> Self:
        if self.neutral is None:
            return self
        if self.values is not None:
            if self.neutral not in self.values:
                raise ValueError(f"neutral = {self.neutral} is none of the values; add it to them")
            return self
        assert self.low is not None
        assert self.high is not None
        if isinstance(self.neutral, str) or not self.low <= self.neutral <= self.high:
            raise ValueError(f"neutral = {self.neutral} lies outside the range; widen it from low to high")
        return self
