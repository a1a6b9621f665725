"""A policy for homebot: lamps are set no brighter than the table ``[control.policies.brightness]`` says."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from homebot.control.policies import Facts, HomePolicy, IssuedCommand, Patterns, Verdict


class BrightnessSettings(BaseModel):
    """The table.

    Attributes:
        commands: The commands that are limited, such as ``turn on lights in bedroom``.
        percent: The highest level.
    """

    model_config = ConfigDict(extra="forbid")

    commands: Patterns
    percent: float = Field(ge=1, le=100)


class Brightness(HomePolicy):
    """Refuses every level above the limit."""

    Settings = BrightnessSettings

    def __init__(self, settings: BaseModel) -> None:
        assert isinstance(settings, BrightnessSettings)
        self._settings = settings

    def judge(self, command: IssuedCommand, facts: Facts) -> Verdict:
        level, most = command.settings.get("level"), self._settings.percent
        is_brighter = isinstance(level, float) and level > most
        if is_brighter and any(pattern.fits(command, facts) for pattern in self._settings.commands):
            reason = f"{command.label} is to be at most {most:g} % bright"
            return Verdict("brightness", allowed=False, reason=reason)
        return Verdict("brightness", allowed=True)
