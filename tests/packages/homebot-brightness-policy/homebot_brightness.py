"""A policy for homebot: no lamp is set brighter than the table ``[control.policies.brightness]`` says."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from homebot.control.command import IssuedCommand
from homebot.control.policies import Facts, HomePolicy, Verdict


class BrightnessSettings(BaseModel):
    """The table.

    Attributes:
        percent: The highest level.
    """

    model_config = ConfigDict(extra="forbid")

    percent: float = Field(ge=1, le=100)


class Brightness(HomePolicy):
    """Refuses every level above the limit."""

    Settings = BrightnessSettings

    def __init__(self, settings: BaseModel) -> None:
        assert isinstance(settings, BrightnessSettings)
        self._percent = settings.percent

    def judge(self, command: IssuedCommand, _facts: Facts) -> Verdict:
        level = command.settings.get("level")
        if isinstance(level, float) and level > self._percent:
            reason = f"{command.label} is to be at most {self._percent:g} % bright"
            return Verdict("brightness", allowed=False, reason=reason)
        return Verdict("brightness", allowed=True)
