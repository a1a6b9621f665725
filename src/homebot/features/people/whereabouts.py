"""Whereabouts of a person, by the signs of phones. Pure."""

import math
from collections.abc import Collection
from typing import Final, Literal, NamedTuple, TypeAlias

from homebot.devices.device import Device, State
from homebot.support.folding import fold

PLACE: Final = "place"
"""The capability of trackers."""

BEACON: Final = "beacon"
"""The kind of trackers that are only heard at home, and never tell that they leave."""

Sign: TypeAlias = Literal["home", "away", "silent", "unknown"]
"""The news of one tracker; ``silent`` is one that is only heard at home, and is not heard now."""


class Whereabouts(NamedTuple):
    """The answer: whether a person is at home, None if unknown, and when silence alone makes that False."""

    is_home: bool | None
    due: float = math.inf


def where_is(signs: Collection[tuple[Sign, float]], now: float, away_after: float) -> Whereabouts:
    """Return where the person of *signs* is.

    A tracker at home decides, then one that tells of another place. Silence means away only if all are silent, each for
    *away_after* seconds.

    Args:
        signs: Each with the time since which it has been so.
    """
    kinds = {kind for kind, _ in signs}
    if "home" in kinds or "away" in kinds:
        return Whereabouts("home" in kinds)
    if kinds != {"silent"}:
        return Whereabouts(None)
    due = max(since for _, since in signs) + away_after
    return Whereabouts(is_home=False) if now >= due else Whereabouts(None, due)


def sign_of(device: Device, state: State | None, tag: str) -> Sign:
    """Return the sign of a tracker of the kind *tag* with the place *state*.

    One that tells of places keeps what it told, also before a restart, until it is stale, or for as long as its
    availability says that it is there. One that is only heard has to be heard since the start.
    """
    if tag == BEACON:
        is_known = device.freshness != "unconfirmed" and state is not None and state.live
    else:
        is_known = device.freshness != "stale" or device.reachable.state == "yes"
    if state is None or not is_known or device.reachable.state == "no" or state.part in device.offline_parts:
        return "unknown"
    place = state.value.plain()
    if isinstance(place, str) and fold(place) not in {"", "unknown", "unavailable"}:
        return "home" if fold(place) == "home" else "away"
    return "silent" if tag == BEACON else "unknown"
