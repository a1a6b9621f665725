"""Declared profiles of devices: the encoding of state and commands in GATT characteristics. Pure.

A *frame* is hexadecimal bytes with fields between them: ``56{red}{green}{blue}00f0aa``. Each field is one byte:
``{on}`` is 01 or 00, ``{level}`` is 0 to ``level_max``, and ``{red}``, ``{green}``, ``{blue}`` are the brightest shade
of a colour. ``..`` is any byte, in a report of a device.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Annotated, Literal, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from homebot.conventions.bluetooth.broadcast import full_uuid
from homebot.conventions.light_color import from_hue_saturation, to_hue_saturation
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

Uuid: TypeAlias = Annotated[str, AfterValidator(full_uuid)]
GattType: TypeAlias = Literal["light", "plug", "switch", "fan", "siren"]

_TOKEN = re.compile(r"\s*(?:([0-9a-fA-F]{2})|\{(\w+)\}|(\.\.))\s*")
_CHANNELS = ("red", "green", "blue")
_FIELDS = ("on", "level", *_CHANNELS)
_MAX_BYTES = 64
_WHITE = (2000, 6500)
_BYTE = 255


def _tokens(frame: str) -> tuple[int | str, ...]:
    """Return the bytes of a frame, and the names of its fields; ``..`` is the empty name.

    Raises:
        ValueError: It is no frame.
    """
    tokens: list[int | str] = []
    at = 0
    while at < len(frame):
        match = _TOKEN.match(frame, at)
        if match is None:
            raise ValueError(f"{frame!r}: {frame[at : at + 8]!r} is neither two hexadecimal digits, {{field}} nor ..")
        digits, name, _ = match.groups()
        if name is not None and name not in _FIELDS:
            raise ValueError(f"{name!r} is not a field; known are {', '.join(_FIELDS)}")
        tokens.append(int(digits, 16) if digits else name or "")
        at = match.end()
    if not 0 < len(tokens) <= _MAX_BYTES:
        raise ValueError(f"a frame has 1 to {_MAX_BYTES} bytes")
    return tuple(tokens)


def _check(frame: str) -> str:
    _tokens(frame)
    return frame


def _check_command(frame: str) -> str:
    if "" in _tokens(frame):
        raise ValueError(".. is only for reports; a command needs every byte")
    return frame


ReportFrame: TypeAlias = Annotated[str, AfterValidator(_check)]
CommandFrame: TypeAlias = Annotated[str, AfterValidator(_check_command)]
GattState: TypeAlias = dict[str, int]
"""The state of a device, as in its frames: the bytes by field."""


class GattProfile(BaseModel):
    """A table ``[gateways.NAME.profiles.PROFILE]``.

    Attributes:
        service: The advertised service that identifies its devices.
        command: The characteristic for commands.
        on: The frame that turns it on.
        off: The frame that turns it off.
        level: The frame that sets the brightness; None if it cannot be dimmed.
        color: The frame that sets the colour; None if it has no colour.
        level_max: The byte of full brightness.
        state: The characteristic with the state; by default that for commands.
        report: The frame of the state; None if it reports nothing.
        response: Whether the device acknowledges commands.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    service: Uuid
    type: GattType = "light"
    command: Uuid
    on: CommandFrame
    off: CommandFrame
    level: CommandFrame | None = None
    color: CommandFrame | None = None
    level_max: Annotated[int, Field(ge=1, le=255)] = 255
    state: Uuid | None = None
    report: ReportFrame | None = None
    response: bool = True

    @model_validator(mode="after")
    def _check_state(self) -> GattProfile:
        if self.state is not None and self.report is None:
            raise ValueError("state needs report: the frame that is read there")
        return self

    @property
    def reported_by(self) -> str:
        """The characteristic with the state."""
        return self.state or self.command

    def part(self) -> Part:
        """Return the part of its devices."""
        reported = set(_tokens(self.report)) if self.report else set()
        rows = (("on_off", self.on, {"on"}), ("level", self.level, {"level"}), ("color", self.color, set(_CHANNELS)))
        capabilities = tuple(
            Capability(name=name, readable=fields <= reported, settable=True)
            for name, frame, fields in rows
            if frame is not None
        )
        return Part(id="", service_type=self.type, capabilities=capabilities)

    def unknown_state(self) -> GattState:
        """Return the state of a device that has reported nothing: off, at full brightness and white."""
        return {"on": 0, "level": self.level_max, **dict.fromkeys(_CHANNELS, _BYTE)}

    def read(self, data: bytes, state: GattState) -> dict[str, PlainValue]:
        """Update *state* from a report, and return its values by capability.

        Raises:
            WireError: It does not match the frame of the profile.
        """
        tokens = _tokens(self.report or "..")
        if len(data) < len(tokens):
            raise WireError(f"it reported {len(data)} bytes, not {len(tokens)}", data)
        fields = dict(state)
        for token, byte in zip(tokens, data, strict=False):
            if isinstance(token, int) and token != byte:
                raise WireError(f"it reported {byte:02x} where the profile has {token:02x}", data)
            if isinstance(token, str) and token:
                fields[token] = byte
        if fields["level"] > self.level_max:
            raise WireError(f"it reported the level {fields['level']} above {self.level_max}", data)
        state.update(fields)
        return self._values(state, {capability.name for capability in self.part().capabilities if capability.readable})

    def write(self, capability: str, value: PlainValue, state: GattState) -> bytes:
        """Return the frame that sets a capability, with other fields from *state*, which is updated.

        Raises:
            RefusedError: The profile has no frame for it.
        """
        fields = {**state, **self._changes(capability, value, state)}
        turns_on = capability == "on_off" or not fields["on"]
        frames = {"on_off": self.on, "level": self.level, "color": self.color}
        frame = (self.on if fields["on"] else self.off) if turns_on and capability in frames else frames.get(capability)
        if frame is None:
            raise RefusedError(capability, "the profile of the device has no frame for it")
        data = bytes(token if isinstance(token, int) else fields[token] for token in _tokens(frame))
        state.update(fields)
        return data

    def _changes(self, capability: str, value: PlainValue, fields: Mapping[str, int]) -> dict[str, int]:
        if capability == "on_off":
            dark = bool(value) and not fields["level"]
            return {"on": int(bool(value)), **({"level": self.level_max} if dark else {})}
        if capability == "level" and isinstance(value, float | int):
            level = {"level": max(1, round(value * self.level_max / 100))} if value > 0 else {}
            return {"on": int(value > 0), **level}
        if capability == "color" and isinstance(value, tuple):
            channels = from_hue_saturation("rgb", value[0], value[1], _WHITE)
            return {"on": 1, **dict(zip(_CHANNELS, map(round, channels), strict=True))}
        raise RefusedError(capability, "the profile of the device has no frame for it")

    def write_frames(self, capability: str, value: PlainValue, state: GattState) -> tuple[bytes, ...]:
        """Return the frames that set a capability, as :meth:`write`; a level or a colour also turns the device on.

        Raises:
            RefusedError: The profile has no frame for it.
        """
        first = self.write(capability, value, state)
        frame = {"level": self.level, "color": self.color}.get(capability)
        if frame is None or not state["on"] or "on" in _tokens(frame):
            return (first,)
        return first, self.write("on_off", True, state)  # noqa: FBT003 - the value

    def _values(self, fields: Mapping[str, int], readable: set[str]) -> dict[str, PlainValue]:
        is_on = bool(fields["on"])
        readings: dict[str, PlainValue] = {}
        if "on_off" in readable:
            readings["on_off"] = is_on
        if "level" in readable:
            is_dark = "on_off" in readable and not is_on
            readings["level"] = 0.0 if is_dark else round(fields["level"] * 100 / self.level_max, 1)
        if "color" in readable:
            channels = tuple(float(fields[channel]) for channel in _CHANNELS)
            readings["color"] = to_hue_saturation("rgb", channels, _WHITE)
        return readings
