"""Text form of commands, the same for every convention, and look-up of parts by text address. Pure."""

from collections.abc import Iterator, Mapping
from operator import attrgetter
from typing import Final

from homebot.devices.capabilities import CAPABILITIES, OWN, SPEED_WORDS, settable_options
from homebot.devices.device import Device, DevicePart, Endpoint
from homebot.devices.names import is_text_address, text_address
from homebot.devices.part import Capability, Part
from homebot.devices.text.states import bounds_of, encode_value, is_share, percent
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.support.numbers import to_number

_WORDS: Final[Mapping[str, Mapping[str, PlainValue]]] = {
    word: {name: known.words[word] for name, known in CAPABILITIES.items() if word in known.words}
    for capability in CAPABILITIES.values()
    for word in capability.words
}
"""The capabilities that a word sets, with their values; it sets the first one that the part has."""

_NUMBERS: Final = tuple(name for name, capability in CAPABILITIES.items() if capability.bare)
"""The capabilities that a bare number may set; it sets the first one that the part has."""


def main_part(parts: tuple[Part, ...]) -> Part | None:
    """Return the main part of a device: the first one that is not a setting or diagnostic, if there is one."""
    for part in parts:
        if not part.category:
            return part
    return parts[0] if parts else None


_SETTABLE = attrgetter("settable")


def accepts_text(part: Part) -> bool:
    """Return whether the part takes commands."""
    return any(map(_SETTABLE, part.capabilities))


def decode_command(text: str, part: Part) -> tuple[str, PlainValue]:
    """Return the capability of *part* that *text* sets, and its value.

    Raises:
        RefusedError: It does not take this text; the message names the accepted ones.
    """
    settable = {capability.name: capability for capability in part.capabilities if capability.settable}
    command = (
        _phrase_command(text, settable)
        or _kelvin_command(text, settable)
        or _number_command(text, settable)
        or _option_command(text, settable)
    )
    if command is None:
        taken = f"this part takes {_known(settable)}" if settable else "it takes no commands; it only reports"
        raise RefusedError(f"the word {text[:40]!r}", taken)
    return command


def _phrase_command(text: str, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    for name, value in _WORDS.get(text, {}).items():
        if name in settable:
            return name, value
    speed = next((name for name in SPEED_WORDS if name in settable), None)
    return (speed, 0.0) if text == "off" and speed is not None else None


def _option_command(text: str, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    for name, capability in settable.items():
        is_free = name == "text" or (name == "floor" and not capability.options)
        if is_free or text in settable_options(name, capability.options):
            return name, text
    for name, capability in settable.items():
        for option in settable_options(name, capability.options):
            if option.casefold() == text:  # such as OFF of a fan
                return name, option
    return None


def encode_command(capability: str, value: PlainValue, part: Part) -> str:
    """Return the text that sets *capability* of *part* to *value*; the inverse of :func:`decode_command`.

    Raises:
        RefusedError: There is none; the message names the accepted texts.
    """
    settable = {offered.name: offered for offered in part.capabilities if offered.settable}
    if capability in settable and _is_within(value, settable[capability]):
        for text in _candidates(capability, value):
            if _is_decoded(text, part, capability, value):
                return text
    raise RefusedError(f"{capability[:40]} {str(value)[:40]}", f"this part takes {_known(settable)}")


def _candidates(capability: str, value: PlainValue) -> Iterator[str]:
    for text, wanted in CAPABILITIES.get(capability, OWN).words.items():
        if wanted == value and type(wanted) is type(value):
            yield text
    own = encode_value(capability, value)
    if own is not None and not isinstance(value, bool):
        yield own


def _is_decoded(text: str, part: Part, capability: str, value: PlainValue) -> bool:
    try:
        name, decoded = decode_command(text, part)
    except RefusedError:
        return False
    if name != capability:
        return capability in SPEED_WORDS and value == 0 and (name, decoded) == ("on_off", False)
    return type(decoded) is type(value) and (decoded == value or isinstance(value, float))  # rounded to three digits


def _is_within(value: PlainValue, capability: Capability) -> bool:
    low, high = bounds_of(capability)
    return not isinstance(value, float) or low <= value <= high


def _kelvin_command(text: str, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    if text.endswith(" K") and "color_temperature" in settable and (kelvin := to_number(text[:-2])) is not None:
        return "color_temperature", kelvin
    return None


def _number_command(text: str, settable: Mapping[str, Capability]) -> tuple[str, PlainValue] | None:
    number = to_number(text)
    name = _number_in(settable)
    if number is None or name is None:
        return None
    if not is_share(name):
        return name, number
    if not 0 <= number <= 1:
        return None
    if name == "level" and number == 0 and "on_off" in settable:
        return "on_off", False
    return name, percent(number)


def _number_in(settable: Mapping[str, Capability]) -> str | None:
    numbers = [
        name for name in settable if name != "color_temperature" and CAPABILITIES.get(name, OWN).kind == "number"
    ]
    only = numbers if len(numbers) == 1 else ()
    return next((name for name in (*_NUMBERS, *only) if name in numbers), None)


def _known(settable: Mapping[str, Capability]) -> str:
    words = [text for text, names in _WORDS.items() if not settable.keys().isdisjoint(names)]
    if not settable.keys().isdisjoint(SPEED_WORDS):
        words.append("off")
    words += ["2700 K"] if "color_temperature" in settable else []
    if (name := _number_in(settable)) is not None:
        words.append("a number from 0 to 1 (0.4 for 40 %)" if is_share(name) else "a number")
    words += [option for name, capability in settable.items() for option in settable_options(name, capability.options)]
    return ", ".join(dict.fromkeys(words)) or "nothing"


def command_address(device: Device, endpoint: Endpoint, text: str) -> str:
    """Return the address to which *text* is sent for *endpoint* of *device*.

    It is the endpoint's own, unless the best route that takes the command is another route of the same gateway to the
    part.
    """
    address = endpoint.command_address
    part = _part_at(device, address, endpoint.gateway) if is_text_address(address) else None
    if part is None or len(part.routes) == 1:
        return address
    try:
        capability, _ = decode_command(text, part.part)
    except RefusedError:
        return address  # the gateway's error names the accepted texts
    for route in part.routes:
        if route.gateway == endpoint.gateway and route.can(capability):
            return text_address(route.key, route.part)
    return address


def others_at(device: Device, address: str, text: str) -> tuple[str, ...]:
    """Return the names of the other parts that take *text*, which is sent to the part at *address*: other gangs.

    They have the same type and category as that part.
    """
    target = _part_at(device, address) if is_text_address(address) else None
    if target is None:
        return ()
    return tuple(
        other.part.name or other.id
        for other in device.parts
        if other is not target
        and other.part.service_type == target.part.service_type
        and other.part.category == target.part.category
        and _takes(other, text)
    )


def part_at(device: Device, gateway: str, address: str) -> DevicePart | None:
    """Return the part of *device* that takes texts at *address* of *gateway*; None if unknown.

    Of several routes to it, only those that lead there are kept, if any is known to.
    """
    is_text = is_text_address(address)
    keys = {
        endpoint.key
        for endpoint in device.endpoints
        if (endpoint.gateway, endpoint.command_address) == (gateway, address)
    }
    for part in device.parts:
        routes = [
            route
            for route in part.routes
            if (
                text_address(route.key, route.part) == address
                if is_text
                else route.gateway == gateway and route.key in keys
            )
        ]
        if routes or address in part.part.writes:
            is_some = 0 < len(routes) < len(part.routes)
            return part.model_copy(update={"routes": tuple(routes)}) if is_some else part
    return None


def _takes(part: DevicePart, text: str) -> bool:
    try:
        decode_command(text, part.part)
    except RefusedError:
        return False
    return True


def _part_at(device: Device, address: str, gateway: str = "") -> DevicePart | None:
    """Return the first part with a route to *address*, of *gateway* if it is given."""
    for part in device.parts:
        for route in part.routes:
            if text_address(route.key, route.part) == address and gateway in {"", route.gateway}:
                return part
    return None
