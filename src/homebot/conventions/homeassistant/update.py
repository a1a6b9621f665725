"""The component ``update``: which version a device runs, and which it could run. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/update.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import partial

from homebot.conventions.description import Codec, DescribedPart, Publications
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.entity import Entity
from homebot.conventions.payload import NO_READINGS, Readings, clean_text, fields_of, shown
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["build_update"]


def build_update(config: DiscoveryConfig) -> DescribedPart:
    """Describe the software of a device. It never gets a command to install anything: that is for people to decide."""
    source = config.required_source("state_topic").without_payload()
    latest = config.source("latest_version_topic", "latest_version_template")
    entity = Entity(config, "x_update")
    if entity.read_text_from(source, partial(_read, is_all=latest is None)):
        entity.add_capability("version")
        entity.add_capability("update_available", readable=latest is None)
    has_latest = entity.read_text_from(latest, _read_latest)
    entity.add_capability("latest_version", readable=has_latest or not source.problem)
    described = entity.build()
    return replace(described, codec=_ReadOnlyCodec(described.codec))


_LONGEST = 255


def _read(text: str, *, is_all: bool) -> Readings:
    if not text or text == "{}":
        return NO_READINGS
    if not text.lstrip().startswith("{"):
        return {"version": None if text == "None" else clean_text(text, _LONGEST)}
    message = fields_of(text)
    found: dict[str, PlainValue] = {}
    installed, latest = (_version(message.get(key)) for key in ("installed_version", "latest_version"))
    if installed is not None:
        found["version"] = installed
    if latest is not None:
        found["latest_version"] = latest
    if found and is_all:
        found["update_available"] = _is_newer(latest, installed)
    return found


def _read_latest(text: str) -> Readings:
    return {"latest_version": None if text == "None" else clean_text(text, _LONGEST)} if text else NO_READINGS


def _version(value: object) -> str | None:
    if isinstance(value, (int, float)):
        return shown(value)
    return clean_text(value, _LONGEST) if isinstance(value, str) else None


def _is_newer(latest: str | None, installed: str | None) -> bool | None:
    """Return whether a version is newer: numbers are compared as such; of others only whether they differ is known."""
    if latest is None or installed is None:
        return None
    if latest.isdecimal() and installed.isdecimal():
        return int(latest) > int(installed)
    return latest != installed


@dataclass(frozen=True, slots=True)
class _ReadOnlyCodec:
    """Reads as another codec does, and refuses all commands."""

    reader: Codec

    def topics(self) -> tuple[str, ...]:
        return self.reader.topics()

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        return self.reader.read(topic, payload, retained=retained)

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:  # noqa: ARG002 - the interface has them
        raise RefusedError(
            f"{shown(capability)} of an update", "homebot does not install software; do it on the device or its bridge"
        )
