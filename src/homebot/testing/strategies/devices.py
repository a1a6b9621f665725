"""Random devices: the settings of each kind and fault, in plain numbers, by choices that shrink well.

The simplest device has no settings. When it shrinks, Hypothesis takes away only a few choices in a row, and all later
ones must still fit. So what may be left out of a house costs few choices while it is plain, and the number of choices
does not depend on other things.
"""

from bisect import bisect_right
from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache
from itertools import accumulate
from typing import Final, TypeVar

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from homebot.config import Table
from homebot.errors import UsageError

__all__ = [
    "FAULT_SETTINGS",
    "KIND_SETTINGS",
    "MADE",
    "PAYLOADS",
    "chosen",
    "commands",
    "devices",
    "moments",
    "one_of",
    "optional",
    "several",
    "target",
]

MADE: Final = 1000
"""Strategies of one sort that are kept: to make one takes longer than to draw from it."""

GRIDS: Final = (3600.0, 600.0, 60.0, 1.0)

NameT = TypeVar("NameT", bound=str)
ValueT = TypeVar("ValueT")

_Settings = Mapping[str, SearchStrategy[object]]


@st.composite
def optional(draw: DrawFn, settings: _Settings) -> Table:
    """Draw tables with any of *settings*, in their order; the simplest has none."""
    if not settings or not draw(_switch):  # one choice where there are none
        return {}
    return {name: draw(value) for name, value in settings.items() if draw(_switch)}


def several(draw: DrawFn, each: SearchStrategy[ValueT], at_least: int, at_most: int) -> list[ValueT]:
    """Draw a list that is seldom empty: hypothesis's own are in half of all examples, and an empty house is no news."""
    values: list[ValueT] = []
    while len(values) < at_least or (draw(_more) and len(values) < at_most):
        values.append(draw(each))
    return values


@lru_cache(MADE)
def one_of(values: tuple[ValueT, ...]) -> SearchStrategy[ValueT]:
    """Return a strategy for one of *values*, the simplest first; the same for the same, since making one takes long.

    Of one value too it makes a choice: else all later choices would slip when the second of two rooms goes.
    """
    return st.sampled_from(values if len(values) > 1 else values * 2)


def target(names: tuple[ValueT, ...]) -> SearchStrategy[ValueT]:
    """Return a strategy for one of a list of things that shrinks itself.

    The last is the simplest: so whichever is meant stays meant while those behind it, and then those before it, go.
    """
    return one_of((*names[-1:], *names[:-1]))


@lru_cache(MADE)
def moments(latest: float, finest: float = 1.0) -> SearchStrategy[float]:
    """Return a strategy for seconds from 0 to *latest*, multiples of *finest*; full hours are simpler than minutes."""
    grids = [grid for grid in GRIDS if grid >= finest]
    *starts, end = accumulate((int(latest // grid) + 1 for grid in grids), initial=0)

    def moment(number: int) -> float:
        which = bisect_right(starts, number) - 1
        return (number - starts[which]) * grids[which]

    return st.integers(0, end - 1).map(moment)


def chosen(names: Collection[str], known: Collection[NameT], what: str) -> tuple[NameT, ...]:
    """Return those of *known* that are in *names*, in the order of *known*.

    Raises:
        UsageError: One of *names* is not known.
    """
    if unknown := sorted(set(names) - set(known)):
        raise UsageError(f"{unknown[0]!r} is no {what}; known are {', '.join(known)}")
    return tuple(name for name in known if name in names)


_switch = st.booleans()
_more = st.sampled_from((False, True, True, True, True, True))


MAX_FAULTS = 2
"""Faults that one device has at most: each wraps the others, and two show how they meet."""

NONSENSE: Final = "nonsense"
"""A command that no device knows."""

PAYLOADS: Final[Mapping[str, Sequence[str]]] = {
    "lamp": ("on", "off", "0.5", "2700 K"),
    "window": ("open", "close", "stop", "0.5"),
    "cover": ("open", "close", "stop", "0.5"),
    "lock": ("lock", "unlock"),
    "contact": (),
    "motion": (),
    "lux": (),
    "power_meter": (),
    "thermostat": ("20", "5", "30"),
    "robot": ("go outside", "stop"),
}
"""The commands of each kind of device."""

_share = st.integers(0, 10).map(lambda tenths: tenths / 10)
_watts = st.sampled_from((10.0, 1.0, 60.0, 2000.0))
_seconds = st.sampled_from((10.0, 1.0, 60.0, 600.0, 3600.0))
_motor: _Settings = {"is_open": _switch, "travel_time": _seconds}

KIND_SETTINGS: Final[Mapping[str, _Settings]] = {
    "lamp": {
        "is_on": _switch,
        "brightness": _share,
        "kelvin": st.sampled_from((2700.0, 1500.0, 6500.0)),
        "rated_watts": _watts,
        "rated_lux": st.sampled_from((100.0, 0.0, 1000.0)),
    },
    "window": _motor,
    "cover": _motor,
    "lock": {"is_locked": _switch, "travel_time": _seconds, "jams": _share},
    "contact": {},
    "motion": {"hold": _seconds},
    "lux": {"share": _share},
    "power_meter": {"step": _watts},
    "thermostat": {
        "celsius": st.integers(-10, 35).map(float),
        "target": st.integers(5, 30).map(float),
        "gain": st.sampled_from((100.0, 0.0, 1000.0)),
        "inertia": st.sampled_from((10_000.0, 1000.0, 100_000.0)),
        "rated_watts": _watts,
    },
    "robot": {"speed": st.sampled_from((1.0, 0.1, 10.0))},
}
"""The settings of each kind of device."""

FAULT_SETTINGS: Final[Mapping[str, _Settings]] = {
    "deaf": {},
    "liar": {"since": st.integers(0, 23).map(lambda hour: hour * 3600.0)},
    "echoing_bridge": {},
    "stuck": {"after": st.sampled_from((2.0, 30.0))},
    "slow": {"delay": _seconds},
    "reverter": {"after": _seconds},
    "lossy": {"share": _share},
    "unplugged": {
        "since": st.integers(0, 23).map(lambda hour: hour * 3600.0),
        "until": st.integers(1, 24).map(lambda hour: hour * 3600.0),
    },
    "flapper": {"every": st.sampled_from((3600.0, 60.0, 600.0))},
    "chatterbox": {"times": st.integers(1, 20), "every": st.sampled_from((1.0, 0.1, 10.0))},
    "late": {"delay": _seconds},
    "silent": {"since": st.integers(0, 23).map(lambda hour: hour * 3600.0)},
}
"""The settings of each fault, the quietest fault first."""


@st.composite
def devices(
    draw: DrawFn,
    rooms: tuple[str, ...],
    doors: Collection[tuple[str, str]],
    kinds: tuple[str, ...],
    faults: tuple[str, ...],
) -> Table:
    """Draw random devices, each as its table in the file."""
    kind = draw(one_of(kinds))
    room = draw(one_of(rooms))
    table: Table = {"kind": kind, "room": room}
    if kind in {"contact", "lock"} and draw(_switch):
        table["door"] = draw(one_of(tuple(sorted({end for door in doors if room in door for end in door} - {room}))))
    table |= draw(_KINDS[kind])
    if faults and (wrong := draw(_faulty(faults))):
        table["faults"] = wrong
    return table


def commands(kind: str) -> SearchStrategy[str]:
    """Return a strategy for commands to a device of *kind*, unknown ones as well."""
    likely = PAYLOADS[kind][:2]  # most failures need these
    return one_of((*PAYLOADS[kind], NONSENSE, *likely))


@st.composite
def _faulty(draw: DrawFn, faults: tuple[str, ...]) -> Table:
    table: Table = {}
    while draw(_switch) and len(table) < MAX_FAULTS:
        fault = draw(one_of(faults))
        table[fault] = draw(_FAULTS[fault])
    return table


_KINDS: Final = {kind: optional(settings) for kind, settings in KIND_SETTINGS.items()}
_FAULTS: Final = {fault: optional(settings) for fault, settings in FAULT_SETTINGS.items()}
