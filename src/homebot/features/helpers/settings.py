"""The table ``[helpers]``."""

from collections.abc import Mapping
from typing import Annotated, Literal, Self, cast

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainValidator, model_validator

from homebot.config import parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.gateways.base import GatewaySettings
from homebot.support.folding import fold
from homebot.units import Seconds
from homebot.words.times import read_moment

_MAX_HELPERS = 100
_MAX_CHOICES = 50
_MAX_TEXT = 500
_MAX_NUMBER = 1e9
MAX_TIMER_S = 7 * 86_400


def _name(text: str) -> str:
    if fold(text) != text.replace("_", " ").strip():
        raise ValueError("a name is written in small letters without accents, such as vacation or movie_night")
    return text


_Name = Annotated[str, Field(min_length=1, max_length=60), AfterValidator(_name)]


class NumberHelper(BaseModel):
    """A number, ``{ value = 30, min = 0, max = 100 }``, or one that counts, ``{ counter = 0 }``."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    value: float | None = None
    counter: Annotated[int, Field(ge=-_MAX_NUMBER, le=_MAX_NUMBER)] | None = None
    min: float | None = None
    max: float | None = None

    @model_validator(mode="after")
    def _check(self) -> Self:
        if (self.value is None) is (self.counter is None):
            raise ValueError("give `value`, such as 30, or `counter`, such as 0")
        if (self.min is None) is not (self.max is None) or not (self.low <= self.first <= self.high):
            raise ValueError("give `min` and `max`, with the value between them")
        return self

    @property
    def first(self) -> float:
        """The value at the first start."""
        return float(self.counter or 0) if self.value is None else self.value

    @property
    def low(self) -> float:
        """The least value."""
        return self.min if self.min is not None else 0.0 if self.counter is not None else -_MAX_NUMBER

    @property
    def high(self) -> float:
        """The greatest value."""
        return _MAX_NUMBER if self.max is None else self.max


class TimerHelper(BaseModel):
    """A timer, ``{ timer = "10m" }``: on while it runs."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    timer: Annotated[Seconds, Field(gt=0, le=MAX_TIMER_S)]


def _time(text: object) -> str:
    try:
        read_moment(str(text))
    except UsageError as exc:
        raise ValueError(str(exc)) from exc
    return str(text)


class TimeHelper(BaseModel):
    """A time of day, ``{ time = "07:00" }``, or of one day, ``{ time = "2026-12-24 07:00" }``."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    time: Annotated[str, PlainValidator(_time)]


class ButtonHelper(BaseModel):
    """A button, ``{ button = true }``, which reports each push as a press."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    button: Literal[True]


class TextHelper(BaseModel):
    """A text, ``{ text = "" }``."""

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    text: Annotated[str, Field(max_length=_MAX_TEXT)]


_TABLES: Mapping[str, type[BaseModel]] = {
    "timer": TimerHelper,
    "time": TimeHelper,
    "button": ButtonHelper,
    "text": TextHelper,
}
"""The tables of helpers by the key that each alone has; others are numbers."""

HelperSetting = bool | float | tuple[str, ...] | NumberHelper | TimerHelper | TimeHelper | ButtonHelper | TextHelper
"""A value that is true or false, a number, texts of which the first is chosen, or a table with limits or a time."""


def _setting(value: object) -> HelperSetting:
    """Check a helper here, because the errors of a union would name all of its members."""
    match value:
        case bool() | NumberHelper() | TimerHelper() | TimeHelper() | ButtonHelper() | TextHelper():
            return value
        case int() | float() if abs(value) <= _MAX_NUMBER:
            return float(value)
        case dict():
            try:
                table = next((_TABLES[key] for key in _TABLES if key in value), NumberHelper)
                return cast("HelperSetting", parse_settings(table, value, "", ""))
            except ConfigError as exc:
                raise ValueError(f"{exc.key}: {exc.reason}".removeprefix(": ")) from exc
        case list() | tuple() if 0 < len(value) <= _MAX_CHOICES and all(
            isinstance(text, str) and text for text in value
        ):
            return tuple(value)
    raise ValueError(
        f"must be true or false, a number, a list of texts, or a table such as {{ counter = 0 }} or "
        f'{{ timer = "10m" }}, got {value!r:.100}'
    )


_Setting = Annotated[HelperSetting, PlainValidator(_setting)]


class HelpersSettings(GatewaySettings):
    """The helpers by name."""

    helpers: Annotated[dict[_Name, _Setting], Field(default_factory=dict, max_length=_MAX_HELPERS)]


def gateway_of_helpers(helpers: object, _: Mapping[str, object]) -> dict[str, dict[str, object]]:
    """Return the table of the gateway, whose devices are *helpers*."""
    return {"helpers": {"helpers": helpers}}
