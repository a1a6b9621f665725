"""Sentences to pick for a routine: of a device, or of time and the house. Each is read back by the grammar. Pure.

Values that a person may change stand in braces: ``temperature of Nursery below {18} °C for {5}m``; ``{…}`` is a text
that only a person knows.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import Final

from homebot.devices import Device
from homebot.devices.capabilities import CAPABILITIES, EVENTS, OWN, settable_options
from homebot.devices.part import Capability
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.terms import And
from homebot.devices.wording.values import main_parts, value_text
from homebot.errors import UsageError
from homebot.features.routines.messages import RoutineSentencesResponse
from homebot.words.conditions import Matches, read_condition
from homebot.words.device_words import DeviceWords, rounded
from homebot.words.own_language import TextKind, in_language, to_english
from homebot.words.queries import parse_query
from homebot.words.steps import Do, WaitUntil, read_step
from homebot.words.triggers import Becomes, Press, read_trigger

_DAYS: Final = ("weekdays", "weekends", "mon", "tue", "wed", "thu", "fri", "sat", "sun")
_TIMES: Final = ("{22:30}", *(f"{{22:30}} on {days}" for days in _DAYS), "every {30}m", "homebot starts")
_SUN: Final = ("sunset", "sunset - {30}m", "sunset + {30}m", "sunrise", "sunrise - {30}m", "sunrise + {30}m")
_SPANS: Final = ("after {22:30}", "before {06:30}", "between {22:30} and {06:30}", *(f"on {days}" for days in _DAYS))
_SUN_IS: Final = ("sun is down", "sun is up")
_PAUSES: Final = ("wait {5}m", "undo", "notify {…}", "stop")
_CLOCKS: Final = ("22:30", "06:30")
_USUAL: Final = 20.0
"""The number of a device that tells neither its value nor its bounds."""

_OF_HELPERS: Final = "number"
"""The number that is set and that routines are compared with, as a limit of light."""

_MAX_OPTIONS: Final = 50
"""Texts of one capability, such as the stations of a radio."""

_READ: Final[Mapping[TextKind, Callable[[str], object]]] = {
    "trigger": read_trigger,
    "condition": read_condition,
    "step": read_step,
}
_ENGLISH: Final = (" at most ", " = ")
"""Words of sentences of which another language has no form, but one for their end."""

_BRACES: Final = str.maketrans("", "", "{}")


def of_house(
    words: DeviceWords, language: str, scenes: Iterable[str], routines: Iterable[str], *, has_place: bool
) -> RoutineSentencesResponse:
    """Return the sentences in *language* that are about no device: of time, rooms, scenes and other routines."""
    rooms = [text for room in words.rooms() for text in room.texts]
    others = [form.format(name) for name in routines for form in ("run routine {}", "routine {} on", "routine {} off")]
    steps = [*_PAUSES, *(f"scene {name}" for name in scenes), *others]
    return RoutineSentencesResponse(
        when=_offered([*_TIMES, *(_SUN if has_place else ())], "trigger", language),
        conditions=_offered([*(_SUN_IS if has_place else ()), *_SPANS, *rooms], "condition", language),
        steps=_offered(steps, "step", language),
    )


def of_device(words: DeviceWords, device: Device, language: str) -> RoutineSentencesResponse:
    """Return the sentences in *language* that mean *device* alone; none for one whose name no sentence can have."""
    if not {"{", "}"}.isdisjoint(device.name):
        return RoutineSentencesResponse()
    cans = [(part.id, can) for part in main_parts(device) for can in part.part.capabilities]
    events = [(part, press) for part, can in cans if can.name in EVENTS for press in _options(can)]
    presses = [words.press(device.id, part, press) for part, press in events]
    states = [text for part, can in cans if can.name not in EVENTS for text in _states(words, device, part, can)]
    people = words.presence(device.id)  # these come and go at a moment, and are there or not
    lasting = [text for state in states if state for text in (state, f"{state} for {{5}}m")]
    waits = [f"wait until {text}, at most {{30}}m" for text in people or lasting]
    steps = [text for part, can in cans if can.settable for text in _steps(words, device, part, can)]
    toggle = [f"{text.removesuffix(' on')} toggle" for text in steps if text.endswith(" on")]
    when = [*presses, *(states if people else lasting), *(f"{text} for {{5}}m" for text in people)]
    if device.service_type == "x_robot" or "x_robot" in device.service_types:
        when += [f"{device.name} arrives in {area}" for area in words.areas]
        steps += [f"{device.name} go to {area}" for area in (*words.areas, "dock")]
    bare = partial(_bare, device=device, reference=words.reference(device.id))
    return RoutineSentencesResponse(
        when=_offered(bare(when, "trigger"), "trigger", language),
        conditions=_offered(bare(people or lasting, "condition"), "condition", language),
        steps=_offered(bare([*steps, *toggle, *waits], "step"), "step", language),
    )


def _bare(texts: Iterable[str], kind: TextKind, device: Device, reference: str) -> Iterator[str]:
    """Yield *texts* with the bare name of *device* for ``name="…"``, where a routine understands the same by it."""
    facets, name = facets_of(device), reference.removeprefix('name="').removesuffix('"')
    for text in texts:
        bare = text.replace(reference, name)
        if bare == text:
            yield text
            continue
        try:
            words, rest = _asked(_READ[kind](bare.translate(_BRACES)))
            strict, others = _asked(_READ[kind](text.translate(_BRACES)))
            named = parse_query(words, lambda query: fits(query, facets))
            is_same = named in {parse_query(strict), And((parse_query(strict),))}
        except UsageError:
            yield text
        else:
            yield bare if is_same and rest == others else text


def _asked(read: object) -> tuple[str, object]:
    """Return the words for a device in a trigger, condition or step, and the rest of it."""
    match read:
        case Becomes(words=words) | Press(words=words):
            return words, replace(read, text="", words="", query=parse_query(""))
        case Matches(state=state, is_none=is_none):
            words, rest = _asked(state)
            return words, (rest, is_none)
        case WaitUntil(state=state, most=most):
            words, rest = _asked(state)
            return words, (rest, most)
        case Do(target=words):
            return words, replace(read, text="", target="")
    return "", read


def _states(words: DeviceWords, device: Device, part: str, can: Capability) -> Iterator[str]:
    """Yield the sentences for what *can* reports: its words, or below and above a number that is measured."""
    row = CAPABILITIES.get(can.name, OWN)
    match row.kind:
        case _ if not can.readable or row.is_momentary:
            return
        case "number" if can.settable and can.name != _OF_HELPERS:
            return
        case "bool":
            texts = (words.trigger(device.id, part, can.name, value) for value in (True, False))
            is_person = device.service_type == "x_person"  # whose leave other languages say in one way
            yield from (text.replace(" has left", " leaves") if is_person else text for text in texts)
        case "number":
            number = _number(device, part, can)
            texts = (words.limit(device.id, part, can.name, number, sign) for sign in ("below", "above"))
            yield from (_with_slot(text, can.name, number) for text in texts)
        case _:
            yield from (words.trigger(device.id, part, can.name, value) for value in _options(can))


def _steps(words: DeviceWords, device: Device, part: str, can: Capability) -> Iterator[str]:
    """Yield the sentences for what *can* be set to."""
    match CAPABILITIES.get(can.name, OWN).kind:
        case "bool":
            yield from (words.command(device.id, part, can.name, value) for value in (True, False))
        case "number":
            number = _number(device, part, can)
            yield _with_slot(words.command(device.id, part, can.name, number), can.name, number)
        case _:
            options = settable_options(can.name, _options(can))
            yield from (words.command(device.id, part, can.name, value) for value in options)


def _options(can: Capability) -> tuple[str, ...]:
    return (can.options or CAPABILITIES.get(can.name, OWN).options)[:_MAX_OPTIONS]


def _number(device: Device, part: str, can: Capability) -> float:
    """Return a number to begin with: the present one, else the middle of its range."""
    known = [one.value.plain() for one in device.states if (one.part, one.capability) == (part, can.name)]
    bounds = can.bounds or CAPABILITIES.get(can.name, OWN).bounds or (_USUAL, _USUAL)
    value = rounded(can.name, known[0] if known else (bounds[0] + bounds[-1]) / 2)
    return round(value, 2) if isinstance(value, float) else _USUAL


def _with_slot(text: str, capability: str, number: float) -> str:
    """Return *text* with *number*, which stands at its end, in braces."""
    limit = value_text(capability, number)
    digits, blank, unit = limit.partition(" ")
    return f"{text.removesuffix(limit)}{{{digits}}}{blank}{unit}" if text else ""


def _offered(texts: Iterable[str], kind: TextKind, language: str) -> tuple[str, ...]:
    """Return those of *texts* that the grammar reads, in *language* where that means the same."""
    offered = []
    for text in dict.fromkeys(filter(None, texts)):
        with suppress(UsageError):
            _READ[kind](text.translate(_BRACES))
            own = _in_language(text, kind, language)
            plain = own.translate(_BRACES)
            is_same = (to_english(plain, kind) or plain) == text.translate(_BRACES)
            is_whole = own.count("{") == text.count("{") and not any(word in own for word in _ENGLISH)
            offered.append(own if is_same and is_whole else text)
    return tuple(offered)


def _in_language(text: str, kind: TextKind, language: str) -> str:
    """Return *text* as *language* says it; its clock times get their braces back, as these are for values."""
    for clock in _CLOCKS:
        text = text.replace(f"{{{clock}}}", clock)
    own = in_language(text, kind, language)
    for clock in _CLOCKS:
        own = own.replace(clock, f"{{{clock}}}")
    return own
