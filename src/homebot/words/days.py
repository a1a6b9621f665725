"""Days of the week and of the year. Pure."""

import re
from calendar import monthrange
from datetime import date
from typing import Final, NamedTuple

from homebot.errors import UsageError
from homebot.support.names import did_you_mean

_WEEK: Final = ("monday", "tuesday", "wednesday", "thursday", "friday", "saturday", "sunday")
_MONTHS: Final = (
    "january",
    "february",
    "march",
    "april",
    "may",
    "june",
    "july",
    "august",
    "september",
    "october",
    "november",
    "december",
)
_LEAP_YEAR: Final = 2024
_YEAR: Final = tuple((month, day) for month in range(1, 13) for day in range(1, monthrange(_LEAP_YEAR, month)[1] + 1))
"""Month and day of each day of a year, the 29th of February included."""
_MIN_LETTERS: Final = 3
_SEVERAL: Final = {
    **dict.fromkeys(("weekdays", "weekday"), "mon-fri"),
    **dict.fromkeys(("weekends", "weekend"), "sat,sun"),
    **dict.fromkeys(("every day", "all days", "daily"), ""),
}
_WEEKS: Final = {"in even weeks": 0, "in odd weeks": 1}
_FROM: Final = re.compile(r"\bfrom (?P<first>[^,]+?) (?:to|until) (?P<last>[^,]+)")
_DATE: Final = re.compile(r"(?P<before>\d{0,2})\.?(?P<month>[a-z]+)(?P<after>\d{0,2})")
_EXAMPLE: Final = "write it like mon-fri, sat,sun, 24 dec or may-sep"


class CalendarDays(NamedTuple):
    """Some days of the week, Monday being 0, as far as they are among some days of the year, as (month, day).

    Attributes:
        weeks: The remainders by 2 of their weeks as ISO 8601 counts these.
    """

    weekdays: frozenset[int] = frozenset(range(7))
    dates: frozenset[tuple[int, int]] = frozenset(_YEAR)
    weeks: frozenset[int] = frozenset(range(2))

    def has(self, day: date) -> bool:
        """Return whether *day* is one of them."""
        is_in_week = day.isocalendar().week % 2 in self.weeks
        return is_in_week and day.weekday() in self.weekdays and (day.month, day.day) in self.dates

    def excludes(self, other: "CalendarDays") -> bool:
        """Return whether no day is one of both."""
        pairs = zip(self, other, strict=True)
        return any(own.isdisjoint(others) for own, others in pairs)

    def others(self) -> "CalendarDays | None":
        """Return all other days; None if there are none, or if these depend on both the week and the year."""
        if self.weeks != EVERY_DAY.weeks:
            return CalendarDays(weeks=EVERY_DAY.weeks - self.weeks)
        if self.dates == EVERY_DAY.dates:
            weekdays = EVERY_DAY.weekdays - self.weekdays
            return CalendarDays(weekdays) if weekdays else None
        if self.weekdays == EVERY_DAY.weekdays:
            return CalendarDays(dates=EVERY_DAY.dates - self.dates)
        return None


EVERY_DAY: Final = CalendarDays()


def read_days(text: str) -> CalendarDays:
    """Return the days *text*: ``mon-fri``, ``weekdays``, ``24 dec``, ``may-sep``, ``sat from May to September``.

    Empty text is all. Days of the week and of the year, if both are given, must both fit.

    Raises:
        UsageError: A day does not exist.
    """
    if type(text) is not str:
        raise UsageError(f"days: {text!r} is not a text; {_EXAMPLE}")
    weekdays: set[int] = set()
    dates: set[tuple[int, int]] = set()
    for part in filter(None, days_text(text).replace(" ", "").split(",")):
        first, dash, last = part.partition("-")
        if (weekday := _weekday(first)) is not None:
            until = _weekday(last) if dash else weekday
            if until is None:
                raise UsageError(_unknown(last))
            weekdays |= {(weekday + number) % 7 for number in range((until - weekday) % 7 + 1)}
            continue
        begin, end = _dates(first)
        end = _dates(last)[1] if dash else end
        dates |= set(_YEAR[begin : end + 1] if begin <= end else (*_YEAR[begin:], *_YEAR[: end + 1]))
    return CalendarDays(frozenset(weekdays or range(7)), frozenset(dates or _YEAR))


def read_days_after_word(text: str) -> CalendarDays | None:
    """Return the days ``on weekdays``, ``in July``, ``from May to September`` or ``in odd weeks``; None for others.

    Raises:
        UsageError: There is no such day.
    """
    if (weeks := _WEEKS.get(text)) is not None:
        return CalendarDays(weeks=frozenset({weeks}))
    word, _, days = text.partition(" ")
    if word == "on" and days:
        return read_days(days)
    if (word == "in" and _month(days.partition("-")[0]) is not None) or (word == "from" and _FROM.fullmatch(text)):
        return read_days(text)
    return None


def days_text(days: str) -> str:
    """Return *days* with commas between them, and dashes for the words between the first and the last of several."""
    text = _FROM.sub(r",\g<first>-\g<last>", days.strip().lower())
    given = re.split(r" ?(?:,|\band\b) ?", text)
    return ",".join(filter(None, (_SEVERAL.get(part, part.removeprefix("in ")) for part in given)))


def _weekday(name: str) -> int | None:
    if len(name) < _MIN_LETTERS:
        return None
    return next((number for number, day in enumerate(_WEEK) if f"{day}s".startswith(name)), None)


def _month(name: str) -> int | None:
    if len(name) < _MIN_LETTERS:
        return None
    return next((number for number, month in enumerate(_MONTHS, 1) if month.startswith(name)), None)


def _dates(text: str) -> tuple[int, int]:
    """Return the places in the year of the first and the last day of a month, or of one day of it twice.

    Raises:
        UsageError: There is no such day.
    """
    found = _DATE.fullmatch(text)
    month = None if found is None else _month(found["month"])
    if found is None or month is None or (found["before"] and found["after"]):
        raise UsageError(_unknown(text))
    if not (number := found["before"] or found["after"]):
        places = [place for place, (of, _) in enumerate(_YEAR) if of == month]
        return places[0], places[-1]
    if (month, int(number)) not in _YEAR:
        raise UsageError(f"days: {_MONTHS[month - 1].title()} has no day {int(number)}")
    place = _YEAR.index((month, int(number)))
    return place, place


def _unknown(name: str) -> str:
    hint = did_you_mean(name, [day[:_MIN_LETTERS] for day in (*_WEEK, *_MONTHS)], _EXAMPLE)
    return f"days: there is no day {name!r}; {hint}"
