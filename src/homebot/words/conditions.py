"""Conditions of routines, as text. Pure."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import time
from functools import lru_cache
from itertools import combinations
from typing import Final, TypeAlias

from homebot.devices.query.terms import Not
from homebot.errors import UsageError
from homebot.words.days import CalendarDays, read_days_after_word
from homebot.words.message_values import Comparison, MessageValue, read_comparison, read_limit, read_value
from homebot.words.mistakes import read_in_any_language
from homebot.words.people import check_known, read_person
from homebot.words.phrases import (
    CHANCE,
    CROSSES,
    ELEVATION,
    ENDED_BY,
    HOUSE_SPAN,
    LAST_RUN,
    LASTING,
    NOBODY,
    NOT,
    RECENT,
    RUN_TODAY,
    SINCE_MOMENT,
    STARTED_BY,
    TIMED_OUT,
)
from homebot.words.times import SunSpan, TimeSpan, longest, read_duration, read_span, read_time
from homebot.words.tokens import split_at
from homebot.words.triggers import (
    SUN,
    Becomes,
    MessageComes,
    Press,
    SunAngle,
    Trigger,
    is_length_of_house,
    is_time_or_person,
    read_mqtt_message,
    read_press,
    read_state,
    read_trigger,
    reject_joined,
)

_PRESENCE: Final = "motion occupied in"
_IN_BED: Final = "tag=bed occupied in"
"""Sensors that the owner tagged as those of a bed, such as a Withings Sleep mat or a zone of an Aqara FP2."""
_EXAMPLES: Final = {
    "": "write it like 'front door open', 'no window open', 'nobody in study', 'Anna is home', 'sun is down', "
    "'after 22:00' or 'on weekdays'",
    "time": "write it like 'after 22:00' or 'between 22:00 and 6:30'",
    "sun": "write it like 'sun is down' or 'after sunset - 30m'",
}


MIN_CHANCE: Final = 2
MAX_CHANCE: Final = 100


@dataclass(frozen=True, slots=True)
class SunIs:
    """The sun is above the horizon, or below it."""

    is_up: bool


@dataclass(frozen=True, slots=True)
class OnDays:
    """It is one of these days."""

    days: CalendarDays


@dataclass(frozen=True, slots=True)
class Matches:
    """At least one device matches, or none does.

    Attributes:
        is_recent: Whether it has matched for less than the length of *state*.
    """

    state: Becomes
    is_none: bool = False
    is_recent: bool = False


@dataclass(frozen=True, slots=True)
class HouseSpan:
    """A part of each day of which a text of the house tells an end, or both; it does not hold while one is unknown."""

    begin: time | MessageValue
    end: time | MessageValue


@dataclass(frozen=True, slots=True)
class Chance:
    """It holds by chance, once in *count* times."""

    count: int


@dataclass(frozen=True, slots=True)
class LastRun:
    """The run of this routine before this one began more than *seconds* ago, or less; one that never ran holds more.

    Attributes:
        seconds: None for the time since midnight in the home's zone.
    """

    seconds: float | None
    is_over: bool


@dataclass(frozen=True, slots=True)
class SinceMoment:
    """The moment that a text of the house tells is more than *seconds* ago, or less; it does not hold while unknown."""

    moment: MessageValue
    seconds: float
    is_over: bool


@dataclass(frozen=True, slots=True)
class StartedBy:
    """This trigger of the routine started this run, or did not; or that of its last wait ended this, or did not."""

    text: str
    trigger: Trigger
    is_other: bool = False
    of_wait: bool = False


@dataclass(frozen=True, slots=True)
class TimedOut:
    """The last wait of this run ended because it was too long, or did not."""

    is_so: bool = True


@dataclass(frozen=True, slots=True)
class AnyOf:
    """At least one of several conditions holds."""

    conditions: tuple["Condition", ...]


Condition: TypeAlias = (
    SunIs
    | SunAngle
    | OnDays
    | TimeSpan
    | SunSpan
    | Matches
    | Press
    | MessageComes
    | LastRun
    | SinceMoment
    | StartedBy
    | TimedOut
    | Comparison
    | Chance
    | HouseSpan
    | AnyOf
)
"""A press, or a message of MQTT, holds in the run that it started."""


@lru_cache(maxsize=2000)  # read for each check of each routine
def read_condition(text: str) -> Condition:
    """Return the condition *text*.

    Raises:
        UsageError: It is none; the message shows how it could be written.
    """
    return read_in_any_language(" ".join(text.split()), "condition", _read_condition)


def _read_condition(plain: str) -> Condition:
    if _is_bracketed(plain):
        return read_condition(plain[1:-1])
    parts = split_at(plain, "or")
    if any(map(_stands_alone, parts if len(parts) > 1 else ())) or _denies(parts):
        return AnyOf(tuple(map(read_condition, parts)))
    if len(parts) > 1 and _is_lasting(parts[0]):  # a length at the end is that of all states before it
        rest = single_conditions(read_condition(" or ".join(parts[1:])))
        return AnyOf((read_condition(parts[0]), *rest))
    if (crossing := CROSSES.match(plain)) is not None:
        way, limit = plain[len(crossing["what"]) :].split(maxsplit=1)
        raise UsageError(f"{plain!r}: a value {way} at a moment; write '{crossing['what']} {limit}'")
    if (found := _of_run(plain) or _of_time(plain)) is not None:
        return found
    reject_joined(plain, "and")
    if _denies(split_at(plain, "and")):
        raise UsageError(f"{plain!r}: this denies a state of the same device; write each as a condition for itself")
    if (press := read_press(plain)) is not None and NOT.match(plain):
        raise UsageError(f"{plain!r}: a press is not denied; write it without the `not`, and the steps into `else`")
    if (denied := NOT.match(plain)) is not None and (message := read_mqtt_message(denied["state"])) is not None:
        return replace(message, is_denied=True)
    return _of_people(plain) or press or read_mqtt_message(plain) or _of_state(plain)


def _is_bracketed(plain: str) -> bool:
    """Return whether *plain* is one lasting condition in brackets."""
    is_in_brackets = plain[:1] == "(" and plain[-1:] == ")"
    return is_in_brackets and _is_lasting(plain[1:-1]) and len(split_at(plain, "or")) == 1


def single_conditions(condition: Condition) -> Iterator[Condition]:
    """Yield *condition*, or those of which one must hold."""
    yield from condition.conditions if isinstance(condition, AnyOf) else (condition,)


def exclude_each_other(one: Condition, other: Condition) -> bool:
    """Return whether both conditions never hold at once."""
    match one, other:
        case SunIs(), SunIs():
            return one != other
        case SunAngle(), SunAngle():
            below, above = sorted((one, other))
            return (
                one.is_azimuth is other.is_azimuth
                and not below.is_above
                and above.is_above
                and below.degrees <= above.degrees
            )
        case OnDays(), OnDays():
            return one.days.excludes(other.days)
        case ((TimeSpan() | SunSpan()), (TimeSpan() | SunSpan())):
            return not longest(one).overlaps(longest(other))
        case Matches(), Matches():
            return one.state.query == other.state.query and one.is_none is not other.is_none
        case _:
            return False


def check_possible(texts: Sequence[str]) -> None:
    """Check that the conditions *texts*, all of which must hold, can hold together.

    Raises:
        UsageError: Two of them never do; the message has the span that was meant, if they are its ends.
    """
    for (text, one), (other_text, other) in combinations([(one, read_condition(one)) for one in texts], 2):
        if exclude_each_other(one, other):
            words = sorted((text, other_text), key=lambda end: end.casefold().startswith("before "))
            ends = [end.split(" ", 1) for end in words if end.casefold().startswith(("after ", "before "))]
            is_span = [end[0].casefold() for end in ends] == ["after", "before"] and ends[0][1] != ends[1][1]
            hint = f"write 'between {ends[0][1]} and {ends[1][1]}'" if is_span else "leave out one of them"
            raise UsageError(f"{text!r} and {other_text!r} never hold together; {hint}")


def _denies(parts: Sequence[str]) -> bool:
    """Return whether one of several *parts* denies a state; a first one without brackets denies all of them."""
    first, *others = parts
    if others and first.casefold().startswith("not ("):
        return True
    for one in filter(None, map(NOT.match, others)):
        with suppress(UsageError):  # `not in hall` is no state
            read_state(one["state"])
            return True
    return False


def _stands_alone(text: str) -> bool:
    """Return whether the condition *text* is not the state of devices, which one query may join."""
    is_lasting = text[:1] == "(" and text[-1:] == ")" and _is_lasting(text[1:-1])
    return is_lasting or _of_run(text) is not None or ELEVATION.match(text) is not None or is_time_or_person(text)


def _house_span(text: str) -> HouseSpan | None:
    """Return the span ``between text of quiet start and 7:00``; None for one without a text of the house."""
    found = HOUSE_SPAN.match(text)
    if found is None or not any(end.casefold().startswith("text of ") for end in found.values()):
        return None
    ends = [
        read_value(found[key])
        if found.get(key, "").casefold().startswith("text of ")
        else read_time(found.get(key, "0:00"))
        for key in ("begin", "end")
    ]
    return HouseSpan(*ends)


def _is_lasting(text: str) -> bool:
    return is_length_of_house(text) or (LASTING.match(text) or RECENT.match(text)) is not None


def _count(number: str, text: str) -> int:
    if not number.isdecimal() or not MIN_CHANCE <= int(number[:4]) <= MAX_CHANCE or len(number) > len(str(MAX_CHANCE)):
        raise UsageError(f"{text!r}: write a chance like '1 in 3', up to {MAX_CHANCE}")
    return int(number)


def _of_run(text: str) -> Condition | None:
    is_denied = text.casefold().startswith("not ")
    plain = text[len("not ") :] if is_denied else text
    if (found := STARTED_BY.match(plain)) is not None:
        return StartedBy(found["what"], read_trigger(found["what"]), is_denied)
    if (ended := ENDED_BY.match(plain)) is not None:
        return StartedBy(ended["what"], read_trigger(ended["what"]), is_denied, of_wait=True)
    if (span := _house_span(plain)) is not None:
        return HouseSpan(span.end, span.begin) if is_denied else span
    if (chance := CHANCE.match(text)) is not None:
        return Chance(_count(chance["count"], text))
    if TIMED_OUT.match(plain) is not None:
        return TimedOut(not is_denied)
    if (since := SINCE_MOMENT.match(plain)) is not None:
        moment, seconds = read_value(f"text of {since['what']}"), read_duration(since["length"], text)
        return SinceMoment(moment, seconds, (since["sign"] in {"over", "more"}) is not is_denied)
    compared = read_limit(plain) or read_comparison(plain)
    return None if compared is None else replace(compared, is_denied=is_denied)


def _of_time(written: str) -> Condition | None:
    text = written.casefold()
    if text.startswith("not "):
        found = _of_time(written[len("not ") :])
        return None if found is None else _denied(found)
    if (is_up := SUN.get(text)) is not None:
        return SunIs(is_up)
    if (days := read_days_after_word(text)) is not None:
        return OnDays(days)
    if (elevation := SunAngle.read(written, ELEVATION)) is not None:
        return elevation
    if RUN_TODAY.match(text) is not None:
        return LastRun(None, is_over=False)
    if (run := LAST_RUN.match(text)) is not None:
        return LastRun(read_duration(run["length"], text), run["sign"] in {"over", "above", "before", "more"})
    if text.removeprefix("the ").startswith("last run"):
        raise UsageError(f"{written!r}: write it like 'last run over 1h ago' or 'last run under 10m ago'")
    return read_span(text)


def _of_people(text: str) -> Matches | None:
    if (found := NOBODY.match(text)) is None:
        return None
    seen = _IN_BED if found["sleeps"] else _PRESENCE
    state = replace(read_state(f"{seen} {found['room']}"), words="")  # no device called Motion
    return Matches(state, found["word"].casefold() == "nobody")


def _of_state(text: str) -> Matches:
    if (recent := RECENT.match(text)) is not None:
        if NOT.match(text):
            raise UsageError(f"{text!r}: ask how long it has been so, without the `not`")
        return Matches(read_state(f"{recent['state']} for {recent['length']}", _EXAMPLES), is_recent=True)
    none = None if read_person(text) else NOT.match(text)
    state = replace(read_state(none["state"] if none else text, _EXAMPLES, is_none=none is not None), is_none=False)
    if none is not None:
        check_known(text, Not(state.query))
    return Matches(state, none is not None)


def _denied(condition: Condition) -> Condition:
    match condition:
        case SunIs():
            return SunIs(not condition.is_up)
        case LastRun():
            return LastRun(condition.seconds, not condition.is_over)
        case SunAngle():
            return condition._replace(is_above=not condition.is_above)
        case OnDays() if (others := condition.days.others()) is not None:
            return OnDays(others)
        case TimeSpan() if condition.begin != condition.end:
            return TimeSpan(condition.end, condition.begin)
        case SunSpan() if condition.begin != condition.end:
            return SunSpan(condition.end, condition.begin)
    raise UsageError("this would never hold; leave out the `not`")
