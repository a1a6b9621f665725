"""Settings of the history: the table ``[history]``."""

from typing import Final, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from homebot.config import Config, parse_settings
from homebot.units import Seconds

_DAY: Final = 86_400.0


class KeepSettings(BaseModel):
    """The keys of ``[history.keep]``; hourly summaries are kept forever.

    Attributes:
        values: How long each value is kept.
        five_minutes: How long five-minute summaries are kept.
        states: How long words, flags and events are kept.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    values: Seconds = 2 * _DAY
    five_minutes: Seconds = 30 * _DAY
    states: Seconds = 365 * _DAY

    @model_validator(mode="after")
    def _check_order(self) -> Self:
        if self.five_minutes < 2 * _DAY or self.values > self.five_minutes:
            raise ValueError("five_minutes must be at least 2d, and no less than values")
        return self


class HistorySettings(BaseModel):
    """The keys of ``[history]``.

    Attributes:
        enabled: Whether to keep a history; by default if devices are remembered, and in a simulated house.
        keep: The table ``[history.keep]``, below.
        batch: Time for which values are gathered, and which a power cut loses: each write costs whole blocks.
        series: The largest number of values with a history; those of devices that were gone at the start do not
            count, and are kept.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    enabled: bool | None = None
    keep: KeepSettings = KeepSettings()
    batch: Seconds = 300.0
    series: int = Field(default=1000, ge=1, le=20_000)


def read_history(config: Config) -> HistorySettings:
    """Return the table ``[history]``.

    Raises:
        ConfigError: It is wrong.
    """
    return parse_settings(HistorySettings, config.features["history"], config.source, "history", config.folder)
