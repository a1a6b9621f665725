"""The components ``date``, ``time`` and ``datetime``: a setting that is a moment, as a text in ISO 8601. Pure.

Source: Home Assistant core 2026.11, ``components/mqtt/date.py``, ``time.py`` and ``datetime.py``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from datetime import date, datetime, time
from typing import TypeAlias

from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings, shown
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["build_moment"]


def build_moment(config: DiscoveryConfig) -> DescribedPart:
    """Describe a date, a time of day, or both, as the component says; what is none is neither read nor sent."""
    kind = config.component
    parse = _PARSERS[kind]
    command = config.required_command()

    def spelled(text: str) -> str | None:
        try:
            return parse(text.strip()[:_LONGEST]).isoformat()
        except ValueError:
            return None

    def read(text: str) -> Readings:
        if text == "None":
            return {"text": None}
        moment = spelled(text)
        return NO_READINGS if moment is None else {"text": moment}

    def write(value: PlainValue, _transition: float) -> Publications:
        moment = spelled(value) if isinstance(value, str) else None
        if moment is None:
            raise RefusedError(f"text {shown(value)}", f"it takes a {kind} in ISO 8601 format")
        if kind == "datetime" and datetime.fromisoformat(moment).tzinfo is None:
            raise RefusedError(f"text {shown(value)}", "it takes a datetime with a time zone")
        return command.publish(moment)

    entity = Entity(config, "x_setting", kind)
    entity.add_value("text", config.source("state_topic"), read, command, write)
    return entity.build()


_LONGEST = 64
_Parser: TypeAlias = Callable[[str], date | time | datetime]
_PARSERS: Mapping[str, _Parser] = {
    "date": date.fromisoformat,
    "datetime": datetime.fromisoformat,
    "time": time.fromisoformat,
}
