"""A codec of parts that publish and take plain text, see :mod:`homebot.devices.text`. Pure."""

from __future__ import annotations

from homebot.conventions.description import Publication, Publications
from homebot.conventions.payload import NO_READINGS, Readings
from homebot.devices.part import Part
from homebot.devices.text.commands import decode_command, encode_command
from homebot.devices.text.states import decoder_for
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["TextCodec"]

_LONGEST = 1000
"""Bytes of a payload that is decoded."""


class TextCodec:
    """The codec of a part that publishes and takes text; see :class:`homebot.conventions.description.Codec`.

    A text is read when it is another one than before, and once more when it is live and was kept by the broker before.
    Of a thermostat a number may be the temperature of the room or the target: it is the target where it answers a
    command with just that number.

    Args:
        part: The part; it reports on the first topic of its ``reads``, and is commanded on the first of its ``writes``.
    """

    __slots__ = ("_awaited", "_decode", "_last", "_part", "_was_retained")

    def __init__(self, part: Part) -> None:
        self._part = part
        self._decode = decoder_for(part.capabilities).decode
        self._last = self._awaited = b""
        self._was_retained = False

    def topics(self) -> tuple[str, ...]:
        """Return the topic that the part publishes on."""
        return self._part.reads

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Readings:
        """Return what *payload* reports that the one before did not."""
        del topic
        if payload == self._last and (retained or not self._was_retained):
            return NO_READINGS
        if len(payload) > _LONGEST:
            return NO_READINGS
        self._last, self._was_retained = payload, retained
        readings = self._decode(payload)
        return self._as_answer(readings) if payload == self._awaited and readings else readings

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:
        """Return what to publish so that *capability* becomes *value*; there is no text for a transition."""
        del transition
        payload = encode_command(capability, value, self._part).encode(errors="replace")
        self.expect(payload)
        return (Publication(self._part.writes[0], payload, qos=1),)

    def expect(self, command: bytes) -> None:
        """Note that *command* was sent to the part, so that its answer may be the same text."""
        self._awaited = command if len(command) <= _LONGEST else b""

    def _as_answer(self, readings: Readings) -> Readings:
        command, self._awaited = self._awaited, b""
        try:
            name, value = decode_command(command.decode(), self._part)
        except (RefusedError, UnicodeDecodeError):
            return readings
        return readings if name in readings else {name: value}
