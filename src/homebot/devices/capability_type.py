"""The columns of the vocabulary: all that is known about the capabilities of one name. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Final, Literal, NamedTuple, TypeAlias

if TYPE_CHECKING:
    from homebot.devices.value import PlainValue

ValueKind: TypeAlias = Literal["bool", "number", "text", "numbers", ""]

_Words: TypeAlias = Mapping[str, frozenset[str]]
_NO_WORDS: Final[_Words] = MappingProxyType({})


class ValueComparison(NamedTuple):
    """The reports that prove that a command for a capability was obeyed.

    Attributes:
        tolerance: By how much a reported number may differ from the commanded one: motors stop a little off, many
            devices count percentages in 100 or 254 steps, and most thermostats half degrees.
        relative_tolerance: The tolerance as a share of the number instead; 0 for none.
        fineness: By how much two numbers may differ and be the same setting; None for half a percent.
        accepts: Further reports that confirm a commanded text.
        on_the_way: Reports that a commanded text is being carried out.
        always_sent: Commanded texts that are sent even if the device reports them already.
        moves: Whether any number means that a motor is on its way.
        zero_is_off: Whether 0 is a different state from a small number.
        rounds: Whether many devices round it to steps of several percent.
        rounds_up: Whether a device rounds it to the next higher step.
    """

    tolerance: float = 0.51
    relative_tolerance: float = 0.0
    fineness: float | None = None
    accepts: _Words = _NO_WORDS
    on_the_way: _Words = _NO_WORDS
    always_sent: frozenset[str] = frozenset()
    moves: bool = False
    zero_is_off: bool = False
    rounds: bool = False
    rounds_up: bool = False


def _words(words: Mapping[str, str]) -> _Words:
    """Return the space-separated words for each commanded text, split."""
    return MappingProxyType({wanted: frozenset(seen.split()) for wanted, seen in words.items()})


_MIREDS = 0.02
"""Whole mireds are up to 1.3 % of a cold white apart (Matter 1.6 application clusters, section 3.2.7)."""

_HALF_STEP = 0.8
"""Percent; devices with 255 or 99 steps."""

_HALF_DEGREE = 0.29
"""°C; half a degree Celsius, or one degree Fahrenheit."""

DIMMER: Final = ValueComparison(tolerance=1.5, fineness=_HALF_STEP, zero_is_off=True, rounds=True)
VOLUME: Final = ValueComparison(tolerance=1.5, fineness=_HALF_STEP, rounds=True)
WHITE: Final = ValueComparison(relative_tolerance=_MIREDS, fineness=math.inf)
MOTOR: Final = ValueComparison(tolerance=3.0, fineness=math.inf, moves=True)
SPEED: Final = ValueComparison(tolerance=5.0, fineness=5.0, zero_is_off=True, rounds_up=True)
SETPOINT: Final = ValueComparison(fineness=_HALF_DEGREE)
HUMIDITY: Final = ValueComparison(tolerance=1.0, fineness=0.51)
OPENING: Final = ValueComparison(
    accepts=_words({"stopped": "open closed"}),
    on_the_way=_words({"open": "opening", "closed": "closing"}),
    always_sent=frozenset({"stopped"}),
)
LOCK: Final = ValueComparison(
    accepts=_words({"open": "unlocked opening"}),
    on_the_way=_words({"locked": "locking", "unlocked": "unlocking", "open": "unlocking"}),
    always_sent=frozenset({"open"}),
)
VACUUM: Final = ValueComparison(
    accepts=_words({"returning": "docked", "spot": "cleaning", "idle": "paused docked"}),
    always_sent=frozenset({"spot", "idle"}),
)
MOWER: Final = ValueComparison(accepts=_words({"docked": "returning"}))
PLAYER: Final = ValueComparison(accepts=_words({"paused": "stopped"}), on_the_way=_words({"playing": "buffering"}))
_ARMED = tuple(f"armed_{mode}" for mode in ("home", "away", "night", "vacation", "custom_bypass"))
_ARMING = dict.fromkeys(_ARMED, "arming pending")
ALARM: Final = ValueComparison(on_the_way=_words({"disarmed": "disarming pending", **_ARMING}))


class CapabilityType(NamedTuple):
    """The meaning of all capabilities of one name.

    Attributes:
        kind: The kind of its values; empty for any.
        cluster: Number of the Matter cluster; None if Matter has none.
        unit: The unit of a number; empty if it has none, or each device names its own.
        bounds: Smallest and largest number; empty if there is none.
        options: The allowed texts; empty if each device names its own.
        is_event: Whether a value is an event, which is over at once, rather than a lasting state: each is reported
            exactly once, even if it equals the previous one.
        is_momentary: Whether setting it twice acts twice.
        is_told_once: Whether a command is sent once and by one route: the usual pulse relay of a garage door stops, and
            then opens, at a second "close" (Shelly knowledge base, "Garage door opener"); a siren starts anew.
        only_reported: Texts that no command sets.
        comparison: How reports show that a command was obeyed.
        sensor: The device type of a sensor for it; empty if there is none.
        is_set: Whether people and programs set it; measurements change all the time and need no reason.
        is_alerting: Whether alerts are about it, although nobody sets it.
        lights_up: Whether setting it turns a light on.
        bare: What a bare number in a text is: the ``number`` itself, or its ``share`` from 0 to 1; empty for nothing,
            unless it is the only number of its part.
        words: The value for each word that sets it, such as ``open``.
        by_state: Whether people set it by its states alone: ``docked``.
        spoken: A further name in commands, where the first that the part takes is meant, and, if it is the only one, in
            queries.
        flags: How false and true are shown to people; by default its name, with ``no`` for false.
        texts: How false and true are told in texts.
    """

    name: str
    kind: ValueKind
    meaning: str
    cluster: int | None = None
    unit: str = ""
    bounds: tuple[float, ...] = ()
    options: tuple[str, ...] = ()
    is_event: bool = False
    is_momentary: bool = False
    is_told_once: bool = False
    only_reported: frozenset[str] = frozenset()
    comparison: ValueComparison = ValueComparison()
    sensor: str = ""
    is_set: bool = False
    is_alerting: bool = False
    lights_up: bool = False
    bare: Literal["", "number", "share"] = ""
    words: Mapping[str, PlainValue] = MappingProxyType({})
    by_state: bool = False
    spoken: str = ""
    flags: tuple[str, str] | tuple[()] = ()
    texts: tuple[str, str] = ("off", "on")
