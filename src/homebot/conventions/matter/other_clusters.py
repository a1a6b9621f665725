"""The other clusters: Switch and Identify. Pure.

Source: Matter 1.4 Application Clusters, 1.2 (Identify), 1.13 (Switch).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from homebot.conventions.matter.endpoint import ClusterInvocation, MatterAbility, MatterEndpoint, MatterOrder
from homebot.conventions.payload import as_fields
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["SWITCH", "other_abilities", "press_of"]

IDENTIFY, SWITCH = 3, 59

_POSITIONS: Final = 0
_LATCHES, _TELLS_RELEASE, _TELLS_LONG, _COUNTS = 1 << 0, 1 << 2, 1 << 3, 1 << 4
_LATCHED, _PRESSED, _LONG, _SHORT_RELEASE, _LONG_RELEASE, _COUNTED = 0, 1, 2, 3, 4, 6
_COUNT_NAMES: Final = {1: "single", 2: "double", 3: "triple", 4: "quadruple"}
_MOST_POSITIONS: Final = 20

_IDENTIFY_SECONDS: Final = 10


def other_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield presses and whether it can make itself known."""
    if endpoint.has(SWITCH, _POSITIONS):
        yield MatterAbility(SWITCH, Capability(name="press", options=_presses(endpoint)))
    if endpoint.has(IDENTIFY, 0) and endpoint.whole(IDENTIFY, 1):
        yield MatterAbility(IDENTIFY, Capability(name="locate", settable=True, readable=False), None, _write_locate)


def press_of(endpoint: MatterEndpoint, event: int, data: object) -> str | None:
    """Return the press that an event of the cluster Switch is; None if it is none, or a part of one.

    A switch that counts presses says so once all are over, others when it is released, or has no release.
    """
    features, fields = endpoint.features(SWITCH), as_fields(data)
    if event == _COUNTED and features & _COUNTS:
        count = fields.get("totalNumberOfPressesCounted", fields.get("1"))
        if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= _MOST_POSITIONS:
            return None
        return _COUNT_NAMES.get(count, f"{count} times")
    if event == _LATCHED and features & _LATCHES:
        position = fields.get("newPosition", fields.get("0"))
        return f"position {position}" if type(position) is int and 0 <= position < _MOST_POSITIONS else None
    if event in {_LONG, _LONG_RELEASE} and features & _TELLS_LONG:
        return "long" if event == _LONG else "long_release"
    if features & (_COUNTS | _LATCHES):
        return None
    return "single" if event == (_SHORT_RELEASE if features & _TELLS_RELEASE else _PRESSED) else None


def _presses(endpoint: MatterEndpoint) -> tuple[str, ...]:
    features = endpoint.features(SWITCH)
    if features & _LATCHES:
        count = endpoint.whole(SWITCH, _POSITIONS) or 2
        return tuple(f"position {number}" for number in range(min(max(count, 2), _MOST_POSITIONS)))
    presses = ["single"]
    if features & _COUNTS:
        most = min(max(endpoint.whole(SWITCH, 2) or 2, 2), _MOST_POSITIONS)
        presses += [_COUNT_NAMES.get(count, f"{count} times") for count in range(2, most + 1)]
    if features & _TELLS_LONG:
        presses += ["long", "long_release"]
    return tuple(presses)


def _write_locate(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    seconds = _IDENTIFY_SECONDS if value is True else 0
    return (ClusterInvocation(IDENTIFY, "Identify", {"identifyTime": seconds}),)
