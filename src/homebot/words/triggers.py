"""Triggers of routines, as text: a state, a press, a time, the sun, or the arrival of a robot. Pure."""

from collections import Counter
from collections.abc import Collection, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Final, NamedTuple, TypeAlias

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device import DevicePart
from homebot.devices.query.terms import Query, ReachableIs, StateIs, leaves, split_near
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.support.names import find_name
from homebot.words.amounts import read_amount
from homebot.words.days import read_days_after_word
from homebot.words.message_values import Comparison, MessageValue, read_comparison, read_value, split_capability
from homebot.words.mistakes import read_in_any_language
from homebot.words.people import HOME_FACTS, check_known, read_move, read_person, starts_unknown
from homebot.words.phrases import (
    ALL,
    ARRIVAL,
    AT_TIME_OF,
    CHANGES,
    CROSSES,
    INTERVAL,
    LASTING,
    LIMIT,
    MESSAGE,
    MOTION,
    NOBODY,
    NOT,
    PRESS,
    STARTS,
    SUN_CROSSES,
)
from homebot.words.queries import parse_query
from homebot.words.times import DaysAndTime, EachHour, SunMoment, read_duration, read_span, time_kind
from homebot.words.tokens import Phrase, quoted, split_at, tokens_of
from homebot.words.vocabulary import CAPABILITY_WORDS

_SIGNS: Final = {"<", ">", "<=", ">="}
_MAX_INTERVAL_BLANKS: Final = 2  # half an hour
MIN_INTERVAL_S: Final = 1.0
_OF_TIME: Final = {"second", "minute", "minutes", "hour", "hours", "day", "days", "night", "morning", "evening", "week"}
_STATES: Final = dict.fromkeys(
    ("", "time", "sun"), "write it like 'hall motion occupied' or 'temperature in nursery below 18 °C'"
)
_EXAMPLES: Final = {
    "": "write it like 'hall motion occupied', 'front door open for 5m', 'Anna arrives', "
    "'temperature in nursery below 18 °C', 'hall button press', '22:00 on weekdays' or 'sunset - 30m'",
    "time": "write a time like '22:00 on weekdays'",
    "sun": "write a moment like 'sunset - 30m'",
}
SUN: Final = {"sun is up": True, "sun is down": False, "it is dark": False, "it is light": True}
"""The texts of conditions about the sun, and whether it is up."""


@dataclass(frozen=True)
class Becomes:
    """A device begins to match a query with a state, such as ``hall motion occupied``.

    Attributes:
        lasting: Seconds for which it must match first.
        words: The query as text, in which names of devices count; empty if *query* is all that is meant.
        is_none: Whether it begins when the last device no longer matches, as in ``no motion in hall for 5m``.
        length: The number of the house by which *lasting* is multiplied, as in ``for {number of pause}m``.
    """

    text: str
    query: Query
    lasting: float = 0.0
    words: str = ""
    is_none: bool = False
    length: MessageValue | None = None

    @cached_property  # as the next ones: each routine is compared with all others
    def states(self) -> tuple[StateIs, ...]:
        """The values that decide."""
        return tuple(term for term in leaves(self.query) if isinstance(term, StateIs))

    @cached_property
    def capabilities(self) -> frozenset[str]:
        """The capabilities with these values."""
        return frozenset(state.capability for state in self.states)

    @cached_property
    def is_of_reach(self) -> bool:
        """True if it only asks whether a device can be reached."""
        return not self.states and any(isinstance(term, ReachableIs) for term in leaves(self.query))

    @cached_property
    def scope(self) -> frozenset[str]:
        """The other terms, as texts: which devices it is about."""
        return frozenset(repr(term) for term in leaves(self.query) if not isinstance(term, StateIs))


@dataclass(frozen=True, slots=True)
class Press:
    """A device that matches a query reports an event, such as the press of a button.

    Attributes:
        value: The event, such as ``double``; empty for any.
        part: The id or name of the button, if the device has several: ``Remote#2``; empty for any.
        words: The query as text, in which names of devices count.
    """

    text: str
    query: Query
    value: str = ""
    part: str = ""
    words: str = ""

    def buttons(self, parts: Collection[DevicePart]) -> list[DevicePart]:
        """Return which of *parts*, those of one device, are the button: an id counts before names."""
        if not self.part:
            return [*parts]
        with_id = [part for part in parts if fold(part.id) == self.part]
        return with_id or [part for part in parts if find_name(self.part, (part.part.name, part.part.tag))]


@dataclass(frozen=True, slots=True)
class RobotArrival:
    """A robot comes into a room, or goes out of it; ``robot`` is any robot."""

    robot: str
    room: str
    leaves: bool = False


@dataclass(frozen=True, slots=True)
class PersonMoves:
    """The arrival or leave of a person, or of the first or last of a household, from a known other place.

    Attributes:
        is_home: The value that *fact* begins to have.
        fact: The capability.
    """

    text: str
    query: Query
    is_home: bool
    fact: str


class SunAngle(NamedTuple):
    """The sun is, or comes, above or below so many degrees over the horizon, or from the north.

    Attributes:
        is_azimuth: Whether the degrees are those from the north, clockwise.
    """

    is_above: bool
    degrees: float
    is_azimuth: bool = False

    @classmethod
    def read(cls, text: str, form: Phrase) -> "SunAngle | None":
        """Return the angle in *text* of one of the forms for it; None if it is none.

        Raises:
            UsageError: It is no number of degrees that the sun may have.
        """
        if (found := form.match(text)) is None:
            return None
        amount, is_azimuth = read_amount(found["degrees"]), found.get("angle") == "azimuth"
        low, high = (0, 360) if is_azimuth else (-90, 90)
        if amount is None or amount.unit not in {"", "°C"} or not low <= float(amount.number) <= high:
            words = "'sun azimuth above 180°', from 0 to 360" if is_azimuth else "'sun elevation below 4°'"
            raise UsageError(f"{text!r}: write degrees like {words}")
        return cls(found["sign"] in {"above", "over", ">", ">="}, float(amount.number), is_azimuth)


@dataclass(frozen=True, slots=True)
class HomebotStarts:
    """A start of homebot, once its devices had time to be found."""


@dataclass(frozen=True, slots=True)
class EachInterval:
    """Again and again after a length of time, such as ``30m``."""

    length: str


@dataclass(frozen=True, slots=True)
class Changes:
    """A device that matches a query reports another value than before, whatever it is.

    Attributes:
        capability: The capability with the value; empty for any.
        words: The query as text, in which names of devices count.
        before: The text of the value before, in small letters; empty for any.
        after: The text of the new value, likewise.
        lasting: Seconds for which it must have the new value first.
    """

    text: str
    query: Query
    capability: str
    words: str
    before: str = ""
    after: str = ""
    lasting: float = 0.0


@dataclass(frozen=True, slots=True)
class MessageComes:
    """A message comes on a topic of MQTT.

    Attributes:
        path: The places of the value in a message that is JSON, from the outermost; none for the whole message.
        value: The text of that value; None for any.
        is_denied: Whether, as a condition, it holds in runs that another message or trigger started.
    """

    topic: str
    path: tuple[str, ...] = ()
    value: str | None = None
    is_denied: bool = False


@dataclass(frozen=True, slots=True)
class AtTimeOf:
    """The time of day that a text of the house tells, such as a helper's; each day.

    Attributes:
        words: The query as text, in which names of devices count.
        capability: That of the text: ``text``, or ``value`` of a sensor.
        offset: Seconds after it, or before it if they are negative.
    """

    text: str
    query: Query
    words: str
    capability: str = "text"
    offset: float = 0.0


@dataclass(frozen=True, slots=True)
class ValuePasses:
    """A value passes another one: the comparison begins to hold, and did not before.

    Attributes:
        lasting: Seconds for which it must hold first.
    """

    text: str
    comparison: Comparison
    lasting: float = 0.0


Trigger: TypeAlias = (
    Becomes
    | Press
    | Changes
    | ValuePasses
    | MessageComes
    | AtTimeOf
    | RobotArrival
    | PersonMoves
    | DaysAndTime
    | SunMoment
    | SunAngle
    | EachInterval
    | EachHour
    | HomebotStarts
)


def capabilities_of(trigger: Trigger) -> frozenset[str]:
    """Return the capabilities whose values *trigger* names; none if it names none."""
    match trigger:
        case Becomes():
            return trigger.capabilities
        case Changes(capability=name):
            return frozenset({name} - {""})
        case ValuePasses(comparison=comparison):
            return frozenset({comparison.first.capability})
    return frozenset()


@lru_cache(maxsize=2000)  # read for each check of each routine
def read_trigger(text: str) -> Trigger:
    """Return the trigger *text*.

    Raises:
        UsageError: It is none; the message shows how it could be written.
    """
    return read_in_any_language(" ".join(text.split()), "trigger", _read_trigger)


def _read_trigger(plain: str) -> Trigger:
    with suppress(UsageError):  # `22:00 on sat and sun` is one time
        if (moment := DaysAndTime.read(plain)) is not None:
            return moment
    if (interval := INTERVAL.match(plain)) is not None and interval["length"].count(" ") <= _MAX_INTERVAL_BLANKS:
        if read_duration(interval["length"], plain) < MIN_INTERVAL_S:
            raise UsageError(f"{plain!r}: the shortest interval is {MIN_INTERVAL_S:g} s")
        return EachInterval(interval["length"])
    if (hourly := EachHour.read(plain)) is not None:
        return hourly
    reject_joined(plain, "or", "and")
    if (found := _read_other(plain)) is not None:
        return found
    crossing = CROSSES.match(plain)
    limit = plain if crossing is None else _as_limit(plain, crossing["what"])
    lasting = LASTING.match(limit)
    if (comparison := read_comparison(lasting["state"] if lasting else limit)) is not None:
        return ValuePasses(plain, comparison, read_duration(lasting["length"], plain) if lasting else 0.0)
    state = read_state(limit, _EXAMPLES)
    if not HOME_FACTS.isdisjoint(state.capabilities) and not (state.lasting and starts_unknown(state.query)):
        words = "'Anna arrives', 'everybody has left' or 'nobody is home'"
        raise UsageError(f"{plain!r} may only have been unknown before; start by {words}")
    return state


def _as_limit(text: str, what: str) -> str:
    """Return ``temperature below 18 °C`` for ``temperature falls below 18 °C``: a state begins in both."""
    return f"{what} {text[len(what) + 1 :].partition(' ')[2]}"


def _read_other(plain: str) -> Trigger | None:
    """Return the trigger *plain* if it is no state of devices."""
    moment = DaysAndTime.read(plain) or SunMoment.read(plain) or SunAngle.read(plain, SUN_CROSSES)
    if moment is not None:
        return moment
    if (message := read_mqtt_message(plain)) is not None:
        return message
    if (timed := AT_TIME_OF.match(plain)) is not None:
        *what, sign, length = ["", "", *timed["what"].split(" ")]
        offset = read_duration(length, plain) * (-1 if sign == "-" else 1) if sign in {"+", "-"} else 0.0
        words = " ".join(what[2:]) if sign in {"+", "-"} else timed["what"]
        return AtTimeOf(plain, parse_query(words), words, timed["told"], offset)
    if STARTS.match(plain) is not None:
        return HomebotStarts()
    person = read_move(plain) or read_person(plain)
    if person is not None:
        return PersonMoves(plain, *person)
    if (found := ARRIVAL.match(plain)) is not None:
        return RobotArrival(
            found["robot"].casefold(), found["room"].strip('"'), leaves=found["word"].casefold() == "leaves"
        )
    return read_press(plain) or _read_change(plain)


def is_time_or_person(text: str) -> bool:
    """Return whether *text* is a condition or trigger, and not the state of devices.

    Raises:
        UsageError: It is one with a mistake.
    """
    plain = text.casefold().removeprefix("not ")
    if plain in SUN or NOBODY.match(plain) or read_span(plain) or _read_other(plain):
        return True
    with suppress(UsageError):  # `on lamps` are no days
        return read_days_after_word(plain) is not None
    return False


def reject_joined(text: str, *words: str) -> None:
    """Check that *text* joins by *words* only states of devices: a query would take others for words of a name.

    Raises:
        UsageError: It joins others.
    """
    for word in () if read_span(text) else words:
        parts = split_at(text, word)
        for part in filter(is_time_or_person, parts if len(parts) > 1 else ()):
            raise UsageError(f"{text!r}: `{word}` joins only states of devices here; write {part!r} for itself")


def button_names(parts: Iterable[DevicePart]) -> list[str]:
    """Return what :class:`Press` may call each of *parts*, all buttons of a device: its id if others have its name."""
    names = [(part.id, part.part.name or part.part.tag or part.id) for part in parts]
    counts = Counter(fold(name) for _, name in names)
    return [name if counts[fold(name)] == 1 else part_id for part_id, name in names]


def read_press(text: str) -> Press | None:
    """Return the event *text*, such as ``hall button press double``; None if it is none.

    Raises:
        UsageError: Its device is not a query.
    """
    if (pressed := PRESS.match(text)) is None:
        return None
    value = pressed["value"].strip("\"'").casefold()
    query, _, part = pressed["query"].rpartition("#")
    if not query or query.endswith(" ") or not part or not {"'", '"'}.isdisjoint(part):
        query, part = pressed["query"], ""
    return Press(text, parse_query(query), value, fold(part), query)


def read_mqtt_message(text: str) -> MessageComes | None:
    """Return the message ``message on home/bell with state.button = left``; None if it is none.

    Raises:
        UsageError: It has no topic, or several.
    """
    if (found := MESSAGE.match(text)) is None:
        return None
    topic, value, path = found["topic"], found.get("value", ""), ""
    if value[:1] not in {"'", '"'}:
        path, _, value = value.rpartition("=")
    is_quoted = topic[:1] in {"'", '"'} and topic[:1] == topic[-1:]
    topic = topic[1:-1] if is_quoted else topic
    if not topic or not {"+", "#"}.isdisjoint(topic) or (" " in topic and not is_quoted):
        raise UsageError(
            f"{text!r}: write one topic, without + and #, in quotation marks if it has blanks, like "
            "'message on home/bell with state = ring'"
        )
    places = tuple(path.strip().split(".")) if path else ()
    return MessageComes(topic, places, value.strip().strip("\"'") if "value" in found else None)


def _read_change(text: str) -> Changes | None:
    """Return the change ``hall thermostat setpoint changes``: words for devices, and those of a capability.

    Raises:
        UsageError: Its device is not a query, or values are named without a capability.
    """
    if (found := CHANGES.match(text)) is None:
        return None
    query, capability = split_capability(found["what"])
    before, after = (fold(found.get(key, "").strip("\"'")) for key in ("before", "after"))
    if before and not capability:
        raise UsageError(f"{text!r}: name the value, like 'front door lock changes from locked to unlocked'")
    lasting = read_duration(found["length"], text) if "length" in found else 0.0
    return Changes(text, parse_query(query), capability, query, before, after, lasting)


def read_state(text: str, examples: Mapping[str, str] = _STATES, *, is_none: bool = False) -> Becomes:
    """Return the state *text*, such as ``front door open for 5m`` or ``no motion in hall for 5m``.

    Args:
        examples: The hints if it is none, by what it seems to be: see :func:`homebot.words.times.time_kind`.
        is_none: Whether it is the rest of a text that begins with ``no``.

    Raises:
        UsageError: It is not a query, or contains no state.
    """
    reject_joined(text, "or", "and")
    lasting = LASTING.match(text)
    state, length = (lasting["state"], read_duration(lasting["length"], text)) if lasting else (text, 0.0)
    state, of_house, length = _split_length(state) if is_length_of_house(text) else (state, None, length)
    if (person := read_person(state)) is not None:
        return Becomes(text, person.query, length, length=of_house)
    if (none := NOT.match(state)) is not None:
        state, is_none = none["state"], True
    state = _with_value_last(state)
    _reject_all(text, state)
    try:
        query = parse_query(state)
        if is_none and MOTION.match(state) and StateIs not in map(type, leaves(query)):
            state = f"{state} occupied"
            query = parse_query(state)
    except UsageError as exc:
        hint = examples[kind] if (kind := time_kind(text)) else _limit_hint(text) or exc
        raise UsageError(f"{text!r}: {hint}") from exc
    check_known(text, query)
    if split_near(query)[0] is not None:
        raise UsageError(f"{text!r}: a distance to a robot starts nothing; write it like 'robot arrives in kitchen'")
    becomes = Becomes(text, query, length, state, is_none, of_house)
    if becomes.capabilities or becomes.is_of_reach:
        return becomes
    if not (chosen := _choice(state)):
        raise UsageError(f"{text!r} names no state; {examples[time_kind(text)]}{_choice_hint(state)}")
    return Becomes(text, parse_query(chosen), length, chosen, is_none, of_house)


def _reject_all(text: str, state: str) -> None:
    """Reject a state of all devices, which would hold as soon as one of them has it."""
    if not ALL.match(state):
        return
    if _OF_TIME.intersection(state.casefold().split()):
        raise UsageError(f"{text!r}: write an interval like 'every 30m', or a time like '22:00 on weekdays'")
    raise UsageError(f"{text!r} would hold as soon as one of them does; ask for the contrary, like 'no window open'")


def _choice_hint(state: str) -> str:
    """Return how a state such as ``mode is day`` is written; empty for others."""
    what, _, value = state.rpartition(" is ")
    return f"; of a helper or device with choices, '{what} option {value}'" if what and " " not in value else ""


def _with_value_last(state: str) -> str:
    """Return *state* as a query: ``temperature below 18 °C in hall``, ``hall sensor temperature below 18 °C``."""
    sign = next((token for token in tokens_of(state) if token.kind == "operator" and token.text in _SIGNS), None)
    if sign is None:
        return state
    before, limit = state[: sign.at - 1].strip(), state[sign.at - 1 :]
    for word in ("in", "of"):
        what, *where = split_at(before, word)
        if where and fold(what.removeprefix("the ")) in CAPABILITY_WORDS:
            place = before[len(what) + len(word) + 1 :].strip()
            return f"{what} {limit} in {place}" if word == "in" else f"{place} {what} {limit}"
    return state


def _choice(state: str) -> str:
    """Return ``mode option=day`` for ``mode option day``: a capability that is a text, and its value; else empty."""
    words = state.split(" ")
    for place in range(1, len(words) - 1):
        capability = CAPABILITIES.get(CAPABILITY_WORDS.get(fold(words[place]), ""))
        if capability is not None and capability.kind in {"text", ""} and not capability.is_event:
            return f"{' '.join(words[: place + 1])}={quoted(' '.join(words[place + 1 :]))}"
    return ""


_UNITS_OF_LENGTH: Final = {"s": 1.0, "m": 60.0, "h": 3600.0}


def is_length_of_house(text: str) -> bool:
    """Return whether *text* ends with a length that the house tells, such as ``for {number of pause}m``."""
    return " for {" in text and text[-2:-1] == "}"


def _split_length(text: str) -> tuple[str, MessageValue, float]:
    """Return the state in *text*, the number of the house behind it, and the seconds of its unit."""
    state, _, length = text.rpartition(" for {")
    value, unit = read_value(length[:-2]), _UNITS_OF_LENGTH.get(length[-1:], 0.0)
    if CAPABILITIES.get(value.capability, OWN).kind != "number" or not unit:
        raise UsageError(f"{text!r}: write a number of the house with s, m or h, like 'for {{number of pause}}m'")
    return state, value, unit


def _limit_hint(text: str) -> str:
    """Return how a limit is written if *text* seems to be one; else empty."""
    found = LIMIT.match(text)
    can = CAPABILITIES.get(CAPABILITY_WORDS.get(fold(found["what"]), "")) if found else None
    if found is None or can is None or can.kind != "number" or " " in found["number"]:
        return ""
    what, area, sign = found["what"], found["area"], found["sign"].removeprefix("is ")
    if area:
        what = f"{area} {what}" if found.get("where") == "of" else f"{what} in {area}"
    limit = f"{found['number'] or 18} {can.unit}".strip()
    return f"write it like '{what} {sign} {limit}'"
