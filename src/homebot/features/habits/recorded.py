"""Recorded days of a house, from its history and its journal. Pure.

Deeds of persons are changes by hand, and commands from the page and of the owner's own clients. The commands of apps,
routines, scenes, robots, agents and other programs may be triggers, but are no habit.
"""

from bisect import bisect_right
from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime, timedelta, tzinfo
from functools import partial
from typing import Final, NamedTuple

from homebot.apps.sun import is_sun_up, sun_time
from homebot.devices.capabilities import EVENTS
from homebot.devices.client_rights import is_from_person
from homebot.devices.command_messages import Setting
from homebot.devices.history_messages import HistorySeries
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.value import PlainValue
from homebot.features.habits.days import DAY, MIN_DAYS, Days, Happening
from homebot.words.device_words import DeviceWords, WatchedRoom, rounded

MAX_HAPPENINGS: Final = 200_000
"""The largest number that is searched, about 40 MB; the newest count."""

_SAME: Final = 30.0
"""Seconds between the command of a person and the value that it leads to."""

_NAMES: Final = ("mon", "tue", "wed", "thu", "fri", "sat", "sun")
_FLAGS: Final[Mapping[str, PlainValue]] = {"true": True, "false": False}


class Home(NamedTuple):
    """The place of a home."""

    zone: tzinfo
    latitude: float | None = None
    longitude: float | None = None


def is_persons(entry: JournalEntry) -> bool:
    """Return whether a person did this by hand, on the page, or as the owner."""
    if entry.kind in {"changed", "reverted"}:  # also within seconds of a command
        return entry.cause == "person"
    return entry.kind == "requested" and is_from_person(entry.issuer, entry.trigger)


def recorded_days(
    words: DeviceWords, series: Sequence[HistorySeries], entries: Sequence[JournalEntry], home: Home
) -> Days:
    """Return the days of *series*, the states of the house, and *entries* of its journal, oldest first."""
    refused = {entry.command for entry in entries if any(not verdict.allowed for verdict in entry.verdicts)}
    happenings = _changes(words, series)
    by_persons = (
        entry for entry in entries if is_persons(entry) and (not entry.command or entry.command not in refused)
    )
    deeds = [deed for entry in by_persons for deed in _deeds(words, entry)]
    known = sorted(_with_deeds(happenings, deeds), key=lambda happening: happening.at)[-MAX_HAPPENINGS:]
    midnights = _midnights(known[0].at, known[-1].at, home.zone) if known else [0.0]
    rooms = words.rooms()
    conditions = {**dict(_calendar(midnights, home)), **dict(_presence(words, rooms, series))}
    moments = {event: _moment(event, home) for event in ("sunrise", "sunset") if home.latitude is not None}
    members = {text: room.devices for room in rooms for text in room.texts}
    return Days(known, lambda at: midnights[_index(midnights, at)], conditions, moments, members)


def _changes(words: DeviceWords, series: Iterable[HistorySeries]) -> Iterator[Happening]:
    for history in series:
        before, is_event = "", history.capability in EVENTS
        for at, word in zip(history.times, history.words, strict=False):
            if is_event:
                text = words.press(history.device, history.part, word)
            else:
                text = words.trigger(history.device, history.part, history.capability, _FLAGS.get(word, word))
            if text and (is_event or word != before):
                yield Happening(at, history.device, f"{history.part} {history.capability}", text, is_press=is_event)
            before = word


def _deeds(words: DeviceWords, entry: JournalEntry) -> Iterator[Happening]:
    """Yield the deed of a person, as the value and the step that sets it; a level says that it is on, too."""
    settings: Iterable[Setting] = entry.settings
    if len(entry.settings) > 1:
        settings = [setting for setting in entry.settings if setting.capability != "on_off"]
    for setting in settings:
        value = setting.value.plain()
        step = words.step(entry.device, entry.part, setting.capability, value)
        is_number = isinstance(value, float)
        text = words.trigger(entry.device, entry.part, setting.capability, rounded(setting.capability, value))
        if step and text:
            what = f"{entry.part} {setting.capability}"
            yield Happening(entry.at.to_seconds(), entry.device, what, text, step, is_press=is_number)


def _with_deeds(happenings: Iterable[Happening], deeds: Iterable[Happening]) -> Iterator[Happening]:
    """Yield *happenings*, those that persons brought about with the step, and the deeds that changed nothing else."""
    times: defaultdict[tuple[str, str, str], list[Happening]] = defaultdict(list)
    for happening in happenings:
        times[happening.device, happening.what, happening.text].append(happening)
    for deed in deeds:
        same = times[deed.device, deed.what, deed.text]
        near = [place for place, happening in enumerate(same) if -_SAME / 6 <= happening.at - deed.at <= _SAME]
        if near:
            same[near[0]] = replace(same[near[0]], step=deed.step)
        else:
            same.append(deed)
    for same in times.values():
        yield from same


def _midnights(since: float, until: float, zone: tzinfo) -> list[float]:
    day = datetime.fromtimestamp(since, zone).replace(hour=0, minute=0, second=0, microsecond=0)
    midnights: list[float] = []
    while (at := day.timestamp()) <= until:
        midnights.append(at)
        day += timedelta(days=1)
    return midnights


def _index(times: Sequence[float], at: float) -> int:
    return max(bisect_right(times, at) - 1, 0)


def _calendar(midnights: Sequence[float], home: Home) -> Iterator[tuple[str, Callable[[float], bool]]]:
    """Yield the conditions of the days and of the sun; a day of the week only if it came often enough."""
    weekdays = [datetime.fromtimestamp(at + DAY / 2, home.zone).weekday() for at in midnights]
    spans = {"on weekdays": frozenset(range(5)), "on weekends": frozenset({5, 6})}
    spans |= {f"on {_NAMES[day]}": frozenset({day}) for day in range(7) if weekdays.count(day) >= MIN_DAYS}

    def is_on(days: frozenset[int], at: float) -> bool:
        return weekdays[_index(midnights, at)] in days

    for text, days in spans.items():
        yield text, partial(is_on, days)
    if home.latitude is not None:
        light = [_light(at, home) for at in midnights]

        def is_light(at: float) -> bool:
            begin, end = light[_index(midnights, at)]
            return begin <= at < end

        yield "sun is up", is_light
        yield "sun is down", lambda at: not is_light(at)


def _presence(
    words: DeviceWords, rooms: Iterable[WatchedRoom], series: Iterable[HistorySeries]
) -> Iterator[tuple[str, Callable[[float], bool]]]:
    """Yield the presence of people at home, and of anyone in each room."""
    known: defaultdict[tuple[str, str], list[HistorySeries]] = defaultdict(list)
    for history in series:
        known[history.device, history.capability].append(history)
    for text, person in words.people().items():
        if at_home := known[person, "at_home"]:
            yield text, partial(_is_any, at_home)
    for room in rooms:
        if seen := [history for sensor in room.sensors for history in known[sensor, "occupancy"]]:
            somebody, nobody = room.texts
            yield somebody, partial(_is_any, seen)
            yield nobody, partial(_is_none, seen)


def _is_any(series: Iterable[HistorySeries], at: float) -> bool:
    for history in series:
        place = bisect_right(history.times, at) - 1
        if place >= 0 and history.words[place] == "true" and at < history.ends[place]:
            return True
    return False


def _is_none(series: Iterable[HistorySeries], at: float) -> bool:
    return not _is_any(series, at)


def _moment(event: str, home: Home) -> Callable[[float], float | None]:
    time = sun_time(event, home.latitude, home.longitude, 0.0)

    def moment(midnight: float) -> float | None:
        return time.on(datetime.fromtimestamp(midnight + DAY / 2, home.zone).date(), home.zone)

    return moment


def _light(midnight: float, home: Home) -> tuple[float, float]:
    """Return when the sun is up on a day; all day, or not at all, in the far north."""
    rise, fall = (_moment(event, home)(midnight) for event in ("sunrise", "sunset"))
    if rise is None or fall is None:
        is_up = is_sun_up(midnight + DAY / 2, home.latitude, home.longitude)
        return (midnight, midnight + DAY) if is_up else (midnight, midnight)
    return rise, fall
