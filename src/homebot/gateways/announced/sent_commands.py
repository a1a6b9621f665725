"""The messages of each setting of a described part, as text for the owner. Pure."""

import math
from collections.abc import Iterator

from homebot.conventions.description import Codec, DescribedPart, Publications, TakesCode
from homebot.devices.capabilities import CAPABILITIES, MOMENTARY, OWN
from homebot.devices.part import Capability
from homebot.devices.text.states import bounds_of
from homebot.devices.value import PlainValue
from homebot.errors import HomebotError, WrongCodeError

MAX_LINES = 64
"""Settings shown of one part; no more are tried, as a template may take milliseconds."""

_MAX_CHARACTERS = 200
_CODE = "CODE"
_COLOR = (0.0, 100.0)


def sent_commands(described: DescribedPart) -> Iterator[str]:
    """Yield a line with payload and address for each setting of a part; none if its gateway encodes by itself.

    A number is shown with its largest value. A codec with memory is not tried: its payloads depend on the reports of
    the device, and it may remember commands too.
    """
    part = described.part
    label = f"{part.name or part.id}: " if part.name or part.id else ""
    if described.remembers:
        yield f"{label}{', '.join(part.writes)}: what is sent depends on what the device reported"
        return
    settings = [
        (settable, value) for settable in part.capabilities if settable.settable for value in _samples(settable)
    ]
    for capability, value in settings[:MAX_LINES]:
        sent = _encode_sent(described.codec, capability.name, value)
        if sent is not None:
            yield f"{label}{capability.name}={_spelt(value)}: {sent}"
    if len(settings) > MAX_LINES:
        yield f"{label}and {len(settings) - MAX_LINES} further settings"


def _samples(capability: Capability) -> tuple[PlainValue, ...]:
    """Return the values that a capability can be set to; only the largest of a number."""
    known = CAPABILITIES.get(capability.name, OWN)
    if capability.options or not known.kind:
        return capability.options
    match known.kind:
        case "bool":
            return (True,) if known.name in MOMENTARY else (True, False)
        case "number":
            _, highest = bounds_of(capability)
            return (highest if math.isfinite(highest) else 1.0,)
        case "numbers":
            return (_COLOR,)
        case _:
            return known.options or ("TEXT",)


def _encode_sent(codec: Codec, capability: str, value: PlainValue) -> str | None:
    """Return the message as text; None if the part refuses *value*."""
    try:
        try:
            return _show(codec.write(capability, value))
        except WrongCodeError:
            return _show(codec.write_with_code(capability, value, _CODE)) if isinstance(codec, TakesCode) else None
    except WrongCodeError:
        return "it takes a code, which is not shown"
    except HomebotError:
        return None


def _show(publications: Publications) -> str:
    texts = []
    for topic, payload, _, retain in publications:
        text = payload.decode(errors="backslashreplace")
        shown = text if len(text) <= _MAX_CHARACTERS else f"{text[:_MAX_CHARACTERS]}… ({len(payload):,} bytes)"
        texts.append(f"{topic} {shown}{' (retained)' if retain else ''}".rstrip())
    return ", ".join(texts) or "nothing"


def _spelt(value: PlainValue) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    if isinstance(value, tuple):
        return ",".join(f"{number:g}" for number in value)
    return f"{value:g}" if isinstance(value, float) else str(value)
