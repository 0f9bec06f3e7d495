"""A varied parameter of a study: a key of the scenario and the values it takes."""

from typing import Annotated, Literal, Self, TypeVar

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

Value = float | int | str | bool
T = TypeVar("T")


def distinct(values: list[T]) -> list[T]:
    """Return the values if there is at least one and none is repeated.

    Raises
    ------
    ValueError
        The list is empty or contains a duplicate.
    """
    if not values:
        raise ValueError("the list is empty; give at least one")
    if len(set(values)) < len(values):
        raise ValueError(f"{values}: contains a duplicate; remove it")
    return values


class Strict(BaseModel):
    """Base model that rejects unknown keys."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, allow_inf_nan=False, use_attribute_docstrings=True
    )


class TiedKey(Strict):
    """A key that is set to the value of a parameter, times a factor, plus an offset."""

    key: str
    """Key of the scenario file; for a staged scene, the name of one of its parameters."""
    factor: float = 1.0
    """Factor of the value."""
    offset: float = 0.0
    """Added to the product."""

    def value(self, value: Value) -> Value:
        """Return the value of the key; a whole number stays one."""
        if not self.is_computed:
            return value
        result = float(f"{self.factor * float(value) + self.offset:.12g}")
        return int(result) if isinstance(value, int) and result.is_integer() else result

    @property
    def is_computed(self) -> bool:
        """True if the value of the key differs from that of the parameter."""
        return (self.factor, self.offset) != (1.0, 0.0)


class Parameter(Strict):
    """A varied parameter: listed values, or a range."""

    key: str
    """Key of the scenario file, e.g. `noise.dropout.random_rate` or `traffic.actor[truck].x_m`; for a staged scene, the
    name of one of its parameters; with `sets`, any name without a dot."""
    sets: list[TiedKey] = Field(default_factory=list)
    """Keys of the scenario file that are tied to the value, e.g. `{ key = "traffic.actor[van].x_m", offset = 20.0 }`;
    instead of `key`, which is then only a name."""
    values: Annotated[list[Value], AfterValidator(distinct)] | None = None
    """Listed values, instead of a range."""
    low: float | None = None
    """Lower end of the range."""
    high: float | None = None
    """Upper end of the range."""
    steps: Annotated[int, Field(ge=2)] | None = None
    """Number of values on the range, including both ends; not used in a study with `samples`, which draws from the
    whole range."""
    scale: Literal["linear", "log"] = "linear"
    """Spacing of the values on the range, and distribution of samples."""
    label: str = ""
    """Axis label of the figures, including the unit; default: the key."""
    neutral: Value | None = None
    """Undisturbed value; required for a search."""

    @model_validator(mode="after")
    def _values_or_a_range(self) -> Self:
        if self.values is not None:
            if (self.low, self.high, self.steps) != (None, None, None):
                raise ValueError("give values, or low and high of a range, not both")
        elif self.low is None or self.high is None or self.low >= self.high:
            raise ValueError("give values, or a range: low below high")
        elif self.scale == "log" and self.low <= 0:
            raise ValueError(f"low = {self.low:g}: must be above 0 for a logarithmic range")
        return self

    @model_validator(mode="after")
    def _tied_keys_are_valid(self) -> Self:
        if self.sets and "." in self.key:
            raise ValueError(f"key = {self.key}: is only a name beside sets, and sets nothing; give one without a dot")
        is_number = all(isinstance(value, float | int) and not isinstance(value, bool) for value in self.values or [])
        for tied in self.sets:
            if tied.is_computed and not is_number:
                raise ValueError(f"sets {tied.key}: factor and offset need numbers; give numbers as values")
        return self

    @property
    def targets(self) -> list[str]:
        """Keys of the scenario that the parameter sets."""
        return [tied.key for tied in self.sets] or [self.key]

    @model_validator(mode="after")
    def _neutral_is_in_range(self) -> Self:
        if self.neutral is None:
            return self
        if self.values is not None:
            if self.neutral not in self.values:
                raise ValueError(f"neutral = {self.neutral} is not in values; add it to them")
            return self
        assert self.low is not None
        assert self.high is not None
        if isinstance(self.neutral, str) or not self.low <= self.neutral <= self.high:
            raise ValueError(f"neutral = {self.neutral} is outside the range; extend low or high to include it")
        return self
