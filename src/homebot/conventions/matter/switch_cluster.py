"""The clusters of buttons and of identification: Switch and Identify. Pure.

Source: Matter 1.4 Application Clusters, 1.2 (Identify), 1.13 (Switch).
"""

from __future__ import annotations

from typing import Final

from homebot.conventions.matter.cluster_row import ClusterRow
from homebot.conventions.matter.endpoint import (
    ClusterInvocation,
    MatterEndpoint,
    MatterOrders,
    field_of,
)
from homebot.conventions.payload import as_fields
from homebot.devices.gateway_messages import Command
from homebot.support.numbers import whole_number

__all__ = ["SWITCH", "SWITCH_ROWS", "press_of"]

IDENTIFY, SWITCH = 3, 59

_POSITIONS: Final = 0
_LATCHES, _REPORTS_RELEASE, _REPORTS_LONG, _COUNTS = 1 << 0, 1 << 2, 1 << 3, 1 << 4
_LATCHED, _PRESSED, _LONG, _SHORT_RELEASE, _LONG_RELEASE, _COUNTED = 0, 1, 2, 3, 4, 6
_COUNT_NAMES: Final = {1: "single", 2: "double", 3: "triple", 4: "quadruple"}
_LONG_NAMES: Final = {_LONG: "long", _LONG_RELEASE: "long_release"}
_MOST_POSITIONS: Final = 20
_IDENTIFY_SECONDS: Final = 10


def press_of(endpoint: MatterEndpoint, event: int, data: object) -> str | None:
    """Return the press that an event of the cluster Switch is; None if it is none, or a part of one.

    A switch that counts presses reports them once all are over, others when it is released, or has no release.
    """
    features, fields = endpoint.features(SWITCH), as_fields(data)
    if event == _COUNTED and features & _COUNTS:
        return _counted_press(whole_number(field_of(fields, 1, "totalNumberOfPressesCounted")))
    if event == _LATCHED and features & _LATCHES:
        return _position_name(whole_number(field_of(fields, 0, "newPosition")))
    if event in _LONG_NAMES and features & _REPORTS_LONG:
        return _LONG_NAMES[event]
    if features & (_COUNTS | _LATCHES):
        return None
    return "single" if event == (_SHORT_RELEASE if features & _REPORTS_RELEASE else _PRESSED) else None


def _counted_press(count: int | None) -> str | None:
    return _count_name(count) if count is not None and 1 <= count <= _MOST_POSITIONS else None


def _count_name(count: int) -> str:
    return _COUNT_NAMES.get(count, f"{count} times")


def _position_name(position: int | None) -> str | None:
    return f"position {position}" if position is not None and 0 <= position < _MOST_POSITIONS else None


def _presses(endpoint: MatterEndpoint) -> tuple[str, ...]:
    features = endpoint.features(SWITCH)
    if features & _LATCHES:
        count = endpoint.whole(SWITCH, _POSITIONS) or 2
        return tuple(f"position {number}" for number in range(min(max(count, 2), _MOST_POSITIONS)))
    most = min(max(endpoint.whole(SWITCH, 2) or 2, 2), _MOST_POSITIONS) if features & _COUNTS else 1
    return (*map(_count_name, range(1, most + 1)), *(_LONG_NAMES.values() if features & _REPORTS_LONG else ()))


def _write_locate(_at: MatterEndpoint, command: Command) -> MatterOrders:
    seconds = _IDENTIFY_SECONDS if command.value.flag else 0
    return (ClusterInvocation(IDENTIFY, "Identify", {"identifyTime": seconds}),)


SWITCH_ROWS: Final = (
    ClusterRow(SWITCH, _POSITIONS, "press", options=_presses),
    ClusterRow(IDENTIFY, 0, "locate", write=_write_locate, when=lambda endpoint: endpoint.whole(IDENTIFY, 1)),
)
