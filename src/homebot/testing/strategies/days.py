"""Random days, and the failing one in a file. The simplest is an hour after midnight in which nothing happens."""

from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from hypothesis import strategies as st
from hypothesis.errors import HypothesisException
from hypothesis.strategies import DrawFn, SearchStrategy

from homebot.errors import UsageError
from homebot.testing.day import Day
from homebot.testing.day_event import HAPPENINGS, DayEvent, What
from homebot.testing.strategies.choices import chosen, moments, one_of, several, target
from homebot.testing.strategies.devices import commands
from homebot.testing.strategies.houses import houses
from homebot.units import parse_duration

HOUR = 3600.0
MAX_HAPPENINGS = 100

_durations = st.sampled_from((0.0, 10.0, 60.0, 600.0, 3600.0))


def days(
    house: SearchStrategy[dict[str, object]] | Mapping[str, object] | str | Path | None = None,
    *,
    what: Collection[str] = HAPPENINGS,
    max_happenings: int = 8,
    max_length: str | float = "24h",
) -> SearchStrategy[Day]:
    """Return a strategy for days.

    A day shrinks towards a simple house, the hour after midnight, and few happenings at full hours.

    Args:
        house: Where: a strategy such as :func:`houses` returns, the tables of one house, or the TOML file that
            describes it; None is any house.
        what: Allowed events, of ``press``, ``tell``, ``cut``, ``pull`` and ``restart``.
        max_happenings: How much happens at most, 0 to 100.
        max_length: How long a day is at most, such as ``"8h"``; from an hour to 24 hours.

    Raises:
        UsageError: An argument is out of its range.
        ConfigError: The file or the tables describe no house.
    """
    hours = int(parse_duration(max_length) // HOUR)
    if not 1 <= hours <= 24:
        raise UsageError(f"max_length must be from 1h to 24h, got {max_length!r}")
    if not 0 <= max_happenings <= MAX_HAPPENINGS:
        raise UsageError(f"max_happenings must be from 0 to {MAX_HAPPENINGS}, got {max_happenings}")
    whats = chosen(what, HAPPENINGS, "happening")
    if house is None:
        house = houses()
    if isinstance(house, str | Path):
        house = Day.load(house).house
    if isinstance(house, Mapping):
        house = st.just(dict(Day(house).house))
    return _days(house, whats, max_happenings if whats else 0, hours)


@st.composite
def _days(
    draw: DrawFn,
    house: SearchStrategy[dict[str, object]],
    whats: tuple[What, ...],
    max_happenings: int,
    max_hours: int,
) -> Day:
    tables = draw(house)
    start = draw(_hours(0, 23))
    length = draw(_hours(1, max_hours))
    devices = tables.get("devices", {})
    kinds = {name: table["kind"] for name, table in devices.items()} if isinstance(devices, dict) else {}
    whats = tuple(what for what in whats if kinds or what == "restart")
    happenings = several(draw, _happenings(whats, kinds, length), 0, max_happenings) if whats else []
    return Day(tables, [replace(happening, at=start + happening.at) for happening in happenings], start, length)


@st.composite
def _happenings(draw: DrawFn, whats: tuple[What, ...], kinds: Mapping[str, str], length: float) -> DayEvent:
    what = draw(one_of((*whats, *whats[:2])))  # the first are likelier: most failures need commands
    at = draw(moments(length))
    if what == "restart":
        return DayEvent(at, what, lasts=draw(_durations), forget=draw(st.booleans()))
    device = draw(target(tuple(kinds)))
    if what == "cut":
        return DayEvent(at, what, device)
    if what == "pull":
        return DayEvent(at, what, device, lasts=draw(_durations))
    return DayEvent(at, what, device, draw(commands(kinds[device])))


def _hours(low: int, high: int) -> SearchStrategy[float]:
    return st.integers(low, high).map(lambda hours: hours * HOUR)


@contextmanager
def saved_if_failing(day: Day, path: str | Path) -> Iterator[None]:
    """Save *day* to *path* when the block raises; the error goes on, and says where the day is.

    Hypothesis runs the shrunk example last, so the file holds that one in the end.

    Args:
        path: The file; a relative one is relative to the working directory.

    Raises:
        UsageError: The file cannot be written.
    """
    try:
        yield
    except HypothesisException:
        raise  # an example that was turned down, not one that failed
    except Exception as exc:
        day.save(path)
        exc.add_note(f"the day is in {path}: Day.load({str(path)!r})")
        raise
