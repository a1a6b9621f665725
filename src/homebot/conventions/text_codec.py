"""A codec of text devices, see :mod:`homebot.devices.text`. Pure."""

from homebot.conventions.description import Publication, Publications
from homebot.conventions.payload import NO_READINGS, Readings, unreadable
from homebot.devices.part import Part
from homebot.devices.text.commands import decode_command, encode_command
from homebot.devices.text.states import decoder_for
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

_MAX_BYTES = 1000
"""Most bytes of a decoded payload."""


class TextCodec:
    """The codec of a text device; see :class:`homebot.conventions.description.Codec`.

    A repeated text is read only if it is live after a retained one, or the first live one after :meth:`write`: an
    unchanged device repeats its state. A number of a thermostat may be the temperature of the room or the target: it is
    the target if it answers a command with the same number.

    Args:
        part: The part, with the state topic first in ``reads`` and the command topic first in ``writes``.
    """

    __slots__ = ("_awaited", "_decoder", "_is_asked", "_last", "_part", "_was_retained")

    def __init__(self, part: Part) -> None:
        self._part = part
        self._decoder = decoder_for(part.capabilities)
        self._last = self._awaited = b""
        self._was_retained = False
        self._is_asked = False

    def topics(self) -> tuple[str, ...]:
        """Return its state topic."""
        return self._part.reads

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Readings:
        """Return the readings of *payload*, unless it is a repetition."""
        del topic
        is_repeated = payload == self._last
        if is_repeated and (retained or not (self._was_retained or self._is_asked)):
            return NO_READINGS
        if len(payload) > _MAX_BYTES:
            return unreadable(payload, f"at most {_MAX_BYTES} bytes")
        self._last, self._was_retained, self._is_asked = payload, retained, self._is_asked and retained
        readings = self._decoder.decode(payload)
        if not readings and self._decoder.expects:
            unreadable(payload, self._decoder.expects)
        if payload != self._awaited or not readings:
            return readings
        answer = self._as_answer(readings)
        if is_repeated and answer is not readings:
            return NO_READINGS  # perhaps the old value
        self._awaited = b""
        return answer

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:
        """Return the command that sets *capability*; text has no transitions."""
        del transition
        texts = [encode_command(capability, value, self._part)]
        if capability == "color_temperature":  # which leaves a lamp off, unlike a brightness
            texts.append(encode_command("on_off", True, self._part))  # noqa: FBT003 - the value
        payloads = [text.encode(errors="replace") for text in texts]
        self.expect(payloads[0])
        self._is_asked = True
        return tuple([Publication(self._part.writes[0], payload, qos=1) for payload in payloads])

    def expect(self, command: bytes) -> None:
        """Record that *command* was sent, so that its answer may be the same text."""
        self._awaited = command if len(command) <= _MAX_BYTES else b""

    def _as_answer(self, readings: Readings) -> Readings:
        try:
            name, value = decode_command(self._awaited.decode(), self._part)
        except (RefusedError, UnicodeDecodeError):
            return readings
        return readings if name in readings else {name: value}
