"""Ranking of the devices near a robot, in metres, with each term explained. Pure.

The cost of a device is the length of the path to it, the cost of the doors on it, the error of its position, and its
shortcomings: each point of relevance below the maximum counts a metre. No term is negative, so the search along the
paths ends as soon as the path alone costs more than the worst of the wanted devices.
"""

import math
from bisect import insort
from collections.abc import Callable, Iterable, Sequence
from collections.abc import Set as AbstractSet
from typing import NamedTuple, TypeAlias, final

from homebot.places.path import Crossing, PathFinder, Spot, Way


class CostTerm(NamedTuple):
    """A cost of a device or a door in metres, and its reason."""

    metres: float
    reason: str


class DoorState(NamedTuple):
    """A door as part of a path.

    Attributes:
        terms: The costs of going through it; an infinite one makes it a wall.
        note: Assumptions about it, in words; empty for none.
    """

    terms: tuple[CostTerm, ...] = ()
    note: str = ""

    @property
    def metres(self) -> float:
        """The sum of its terms."""
        return _metres(self.terms)


Terms: TypeAlias = Callable[[str], Sequence[CostTerm]]
"""Returns the costs of a device apart from the path."""

Doors: TypeAlias = Callable[[str], DoorState]


@final
class NearDevice(NamedTuple):
    """A device near a robot."""

    cost: float
    device: str
    route: Way
    terms: tuple[CostTerm, ...]


def nearest(
    finder: PathFinder,
    start: Spot,
    crossing: Crossing,
    wanted: AbstractSet[str],
    terms: Terms,
    *,
    total: int,
    within: float = math.inf,
    least: float = 0.0,
    limit: int = 0,
) -> tuple[list[NearDevice], int]:
    """Return the best *limit* of the *wanted* devices, best first, and the number near enough.

    Args:
        within: Most metres of the shortest path, closed doors included; a locked door is a wall.
    """
    if not math.isinf(within):
        wanted = finder.within(start, lambda door: math.inf if math.isinf(crossing(door)) else 0.0, wanted, within)
        total = len(wanted)
    devices: list[NearDevice] = []
    for route in finder.nearest(start, crossing, wanted) if total else ():
        way = route.path + route.extra
        if limit and len(devices) >= limit and way + least >= devices[limit - 1].cost:
            break
        own = tuple(terms(route.target))
        insort(devices, NearDevice(way + _metres(own), route.target, route, own))
        if len(devices) == total:
            break
    return (devices[:limit] if limit else devices), total


def _metres(terms: Iterable[CostTerm]) -> float:
    return sum([term.metres for term in terms])


def cost_text(device: NearDevice, doors: Doors, *, is_exact: bool = True) -> str:
    """Return the cost of *device* and its terms, such as ``10.1 m = 7.1 path by Front door + 3.0 …``.

    Args:
        is_exact: Whether the positions of robot and device are known, rather than only their rooms.
    """
    route = device.route
    states = [(name, doors(name)) for name in route.doors]
    path = f"{route.path:.1f} path{_by_doors(states)}"
    name_of = {name: "that door" if len(states) == 1 else name for name, _ in states}
    terms = [CostTerm(term.metres, f"{name_of[name]} {term.reason}") for name, state in states for term in state.terms]
    shown = [path, *(f"{term.metres:.1f} {term.reason}" for term in (*terms, *device.terms) if term.metres >= _SHOWN)]
    return f"{'' if is_exact else 'about '}{device.cost:.1f} m = {' + '.join(shown)}"


def _by_doors(states: Iterable[tuple[str, DoorState]]) -> str:
    ways = [f"{name} ({state.note})" if state.note else name for name, state in states]
    return f" by {', '.join(ways)}" if ways else ""


_SHOWN = 0.05
