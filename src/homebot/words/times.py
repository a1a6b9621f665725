"""Lengths of time, and times of the day and of the sun. Pure."""

import re
from collections.abc import Callable
from contextlib import suppress
from datetime import date, datetime, time, timedelta, tzinfo
from typing import Final, NamedTuple

from homebot.errors import UsageError
from homebot.units import MAX_WAIT, parse_duration
from homebot.words.days import EVERY_DAY, days_text, read_days, read_days_after_word

MAX_OFFSET_S: Final = 43_200.0
"""Seconds from an event of the sun, so that each stays on its own day."""

SUN_EVENTS: Final = ("dawn", "sunrise", "noon", "sunset", "dusk")
_SUN_HOURS: Final = {"dawn": (1, 9), "sunrise": (2, 10), "noon": (11, 14), "sunset": (14, 23), "dusk": (15, 24)}
"""The earliest and the latest hour of each event."""
_ALIKE: Final = 0.8
_DATE_LENGTH: Final = len("2026-12-24")
_SUN: Final = re.compile(rf"(?P<event>{'|'.join(SUN_EVENTS)})(?: ?(?P<sign>[+-]) ?(?P<offset>.+))?")
_TIME: Final = re.compile(r"([01]?\d|2[0-3]):([0-5]\d)(?::([0-5]\d))?", re.ASCII)
_CLOCK: Final = re.compile(r"(?P<time>\d{1,2}:\d\d(?::\d\d)?)(?: (?P<days>(?:on|in|from) .+))?")
_HOURLY: Final = re.compile(r"(?:at :(?P<after>[0-5]\d) every hour|every hour at :(?P<minute>[0-5]\d))")
_OTHER_CLOCK: Final = re.compile(
    r"(?:(?:every(?! day) |on )?(?P<first>(?!at\b)[a-z]\D*?) )?(?:at )?(?P<hour>\d{1,2})"
    r"(?:[:.h](?P<minute>\d\d))? ?(?P<half>[ap]m|o'?clock|h)?(?: (?:every(?! day) |on )?(?P<days>\D+))?"
)
_BETWEEN: Final = re.compile(r"between (?P<begin>.+?) and (?P<end>.+)")
_HALF: Final = re.compile(r"(?P<word>after|before) (?P<end>.+)")


def read_time(text: object) -> time:
    """Return the time of day *text*, such as ``22:00`` or ``7:30:15``.

    Raises:
        UsageError: It is not a time of day.
    """
    if not isinstance(text, str) or (found := _TIME.fullmatch(text.strip())) is None:
        example = (isinstance(text, str) and _meant_time(text.casefold()).partition(" on ")[0]) or "22:00 or 7:30:15"
        raise UsageError(f"{text!r} is not a time of day; write it like {example}")
    hour, minute, second = (int(part or 0) for part in found.groups())
    return time(hour, minute, second)


class Moment(NamedTuple):
    """A time of day, as text, perhaps of one day alone."""

    clock: str
    day: date | None = None


def read_moment(text: str) -> Moment:
    """Return the moment ``7:00``, ``2026-12-24 7:00`` or ``2026-12-24``, which is that day's midnight.

    Raises:
        UsageError: It is none.
    """
    day: date | None = None
    with suppress(ValueError):
        day = date.fromisoformat(text[:_DATE_LENGTH])
    clock = text if day is None else text[_DATE_LENGTH:].lstrip(" T") or "0:00"
    read_time(clock)
    return Moment(clock, day)


def shifted_moment(text: str, offset: float, zone: tzinfo) -> str:
    """Return the moment *text*, which may have a time zone, *offset* seconds later, as :func:`read_moment` takes it.

    Raises:
        UsageError: It is none.
    """
    with suppress(ValueError):
        if (moment := datetime.fromisoformat(text)).tzinfo is not None:
            return f"{moment.astimezone(zone) + timedelta(seconds=offset):%Y-%m-%d %H:%M:%S}"
    clock, day = read_moment(text)
    if not offset:
        return text
    at = datetime.combine(day or date.min + timedelta(days=1), read_time(clock)) + timedelta(seconds=offset)
    return f"{at:%H:%M:%S}" if day is None else f"{at:%Y-%m-%d %H:%M:%S}"


class SunMoment(NamedTuple):
    """A moment relative to an event of the sun; *offset* is a text such as ``-30m``."""

    event: str
    offset: str

    @property
    def seconds(self) -> float:
        """The offset."""
        length = read_duration(self.offset.removeprefix("-"))
        return -length if self.offset.startswith("-") else length

    @classmethod
    def read(cls, text: str) -> "SunMoment | None":
        """Return the moment *text*, such as ``sunset - 30m``; None if it is none.

        Raises:
            UsageError: Its offset is not a duration, or more than 12 hours.
        """
        found = _SUN.fullmatch(text.casefold())
        if found is None:
            return None
        offset = found["offset"] or "0s"
        if read_duration(offset, f"{found['event']} {found['sign']} {offset}") > MAX_OFFSET_S:
            raise UsageError(f"{text!r}: {offset} is more than 12 hours from the {found['event']}")
        return cls(found["event"], f"{'-' if found['sign'] == '-' else ''}{offset}")


class DaysAndTime(NamedTuple):
    """A time of day, such as ``22:00``, on some days, such as ``mon-fri`` or ``24 dec``; empty for all."""

    time: str
    days: str

    @classmethod
    def read(cls, text: str) -> "DaysAndTime | None":
        """Return the time *text*, such as ``22:00 on weekdays`` or ``on 24 Dec``; None if it is none.

        Days of the year without a time begin at midnight.

        Raises:
            UsageError: There is no such time or day, or it is written otherwise.
        """
        found = _CLOCK.fullmatch(text)
        if found is None and _is_date(text.casefold()):
            return cls("0:00", days_text(text.casefold().removeprefix("on ")))
        if found is None:
            if meant := _meant_time(text.casefold()):
                raise UsageError(f"{text!r}: write a time like '22:00 on weekdays', here {meant!r}")
            return None
        read_time(found["time"])
        days = days_text((found["days"] or "").removeprefix("on "))
        read_days(days)
        return cls(found["time"], days)


class EachHour(NamedTuple):
    """A minute of each hour."""

    minute: int

    @classmethod
    def read(cls, text: str) -> "EachHour | None":
        """Return the minute of ``at :15 every hour``; None if it is none."""
        found = _HOURLY.fullmatch(text.casefold())
        return None if found is None else cls(int(found["after"] or found["minute"]))


class TimeSpan(NamedTuple):
    """A part of each day; if *end* is not after *begin*, it lasts over midnight, and a whole day if both are one."""

    begin: time
    end: time

    def overlaps(self, other: "TimeSpan") -> bool:
        """Return whether a time of day is in both."""
        return self.has(other.begin) or other.has(self.begin)

    def has(self, now: time) -> bool:
        """Return whether the time of day *now* is in the span."""
        if self.begin < self.end:
            return self.begin <= now < self.end
        return now >= self.begin or now < self.end


class SunSpan(NamedTuple):
    """A part of each day of which the sun tells an end, or both."""

    begin: time | SunMoment
    end: time | SunMoment

    def on_day(self, time_of: Callable[[SunMoment], time | None]) -> TimeSpan | None:
        """Return the part of one day, with the times of *time_of*; None if the sun does not rise or set then."""
        begin, end = (one if isinstance(one, time) else time_of(one) for one in self)
        return None if begin is None or end is None else TimeSpan(begin, end)


def longest(span: TimeSpan | SunSpan) -> TimeSpan:
    """Return *span* as long as it is on any day of the year where the sun rises and sets daily."""

    def moment(at: time | SunMoment, place: int) -> time:
        if isinstance(at, time):
            return at
        minutes = round(_SUN_HOURS[at.event][place] * 60 + at.seconds / 60)
        return time(*divmod(min(max(minutes, 0), 24 * 60 - 1), 60))

    return TimeSpan(moment(span.begin, 0), moment(span.end, 1))


def read_span(text: str) -> TimeSpan | SunSpan | None:
    """Return the span *text*: ``after 22:00``, ``before sunrise``, ``between sunset - 30m and 6:30``; None for none.

    Raises:
        UsageError: A time of it does not exist.
    """
    if (found := _BETWEEN.fullmatch(text)) is not None:
        begin, end = (SunMoment.read(one) or read_time(one) for one in found.groups())
    elif (half := _HALF.fullmatch(text)) is not None and (half["end"][0].isdigit() or SunMoment.read(half["end"])):
        at = SunMoment.read(half["end"]) or read_time(half["end"])
        begin, end = (at, time()) if half["word"] == "after" else (time(), at)
    else:
        return None
    return TimeSpan(begin, end) if isinstance(begin, time) and isinstance(end, time) else SunSpan(begin, end)


def time_kind(text: str) -> str:
    """Return ``time`` or ``sun`` if *text* seems to mean a time or a moment of the sun; else empty."""
    if re.search(r"\b\d{1,2}[:.]\d\d\b", text):
        return "time"
    from difflib import get_close_matches  # noqa: PLC0415 - only after a mistake

    words = text.casefold().split()
    is_sun = "sun" in words or any(get_close_matches(one, SUN_EVENTS, cutoff=_ALIKE) for one in words)
    return "sun" if is_sun else ""


def read_duration(text: str, whole: str = "", unit: str = "m") -> float:
    """Return a length of time in seconds: ``5m``, ``30 s``, ``2 hours``.

    Args:
        whole: The text that ends with it, for the error.
        unit: The unit that is proposed if it has none.

    Raises:
        UsageError: It is not a duration.
    """
    if whole and text[-1].isdigit():
        raise UsageError(f"{whole!r}: a length of time has a unit; write it like '{whole}{unit}'")
    return parse_duration(text, most=MAX_WAIT)


def _is_date(text: str) -> bool:
    """Return whether *text* is ``on`` and single days of the year."""
    if not text.startswith("on ") or text.isdecimal():
        return False
    with suppress(UsageError):  # `on lamps` are no days
        days = read_days_after_word(text)
        return days is not None and days.dates != EVERY_DAY.dates
    return False


def _meant_time(text: str) -> str:
    """Return the time that *text* is in other words, such as ``every day at 7`` or ``10pm``; empty if it is none."""
    if text.isdigit() or (found := _OTHER_CLOCK.fullmatch(text)) is None:
        return ""
    hour, days = int(found["hour"]), found["first"] or found["days"] or ""
    if found["half"] in {"am", "pm"}:
        hour = hour % 12 + 12 * (found["half"] == "pm")
    at = f"{hour:02}:{found['minute'] or '00'}"
    if not _TIME.fullmatch(at):
        return ""
    try:
        read_days(days)
    except UsageError:
        return ""
    return f"{at} on {days}" if days_text(days) else at
