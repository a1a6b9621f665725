"""The clusters of closures, such as garage doors, gates, roof windows and blinds since Matter 1.5. Pure.

A closure opens and closes as a whole; its panels, endpoints of their own, have positions.

Source: Matter 1.5 Application Clusters, 5.4 (Closure Control), 5.5 (Closure Dimension).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.matter.endpoint import ClusterInvocation, MatterAbility, MatterEndpoint, MatterOrder
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue

__all__ = ["closure_abilities", "is_covering"]

CLOSURE, DIMENSION = 260, 261

_MAIN_STATE, _STATE, _TARGET = 1, 3, 4
_POSITIONS, _LATCHES, _INSTANT = 1 << 0, 1 << 1, 1 << 2
_MOVING: Final = 1
_CLOSED: Final = 0
_MOVE_TO: Final = {"closed": 0, "open": 1}
_STOP: Final = 0
_MOVES: Final = ("open", "closed", "opening", "closing", "stopped")

_COVERING: Final = (0x44, 0)
"""The tag of closures that cover a window."""

_PANEL_STATE: Final = 0
_PANEL_TAGS: Final = 0x45
_TILT: Final = 1
"""The tag of a panel with turning slats."""


def closure_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield the movement of a closure, and the position of a panel."""
    if endpoint.has(CLOSURE, _STATE) and endpoint.features(CLOSURE) & _POSITIONS:
        stops = endpoint.accepts(CLOSURE, _STOP) and not endpoint.features(CLOSURE) & _INSTANT
        options = _MOVES if stops else _MOVES[:-1]
        yield MatterAbility(
            CLOSURE, Capability(name="movement", settable=True, options=options), _read_movement, _write_movement
        )
    if endpoint.has(DIMENSION, _PANEL_STATE) and endpoint.features(DIMENSION) & _POSITIONS:
        name = "tilt" if (_PANEL_TAGS, _TILT) in endpoint.tags else "position"
        yield MatterAbility(DIMENSION, Capability(name=name, settable=True), _read_position, _write_position)


def is_covering(endpoint: MatterEndpoint) -> bool:
    """Return whether its tags say that it is a blind, shutter or awning rather than a door, gate or window."""
    return _COVERING in endpoint.tags


def _read_movement(endpoint: MatterEndpoint) -> PlainValue:
    position = _position(endpoint, CLOSURE, _STATE)
    if endpoint.whole(CLOSURE, _MAIN_STATE) == _MOVING:
        target = _position(endpoint, CLOSURE, _TARGET)
        return None if target is None else "closing" if target == _CLOSED else "opening"
    return None if position is None else "closed" if position == _CLOSED else "open"


def _write_movement(
    endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    option = require_option("movement", value, (*_MOVE_TO, "stopped"))
    if option == "stopped":
        return (ClusterInvocation(CLOSURE, "Stop"),)
    payload: dict[str, object] = {"position": _MOVE_TO[option]}
    if endpoint.features(CLOSURE) & _LATCHES:
        payload["latch"] = option == "closed"
    return (ClusterInvocation(CLOSURE, "MoveTo", payload, is_timed=True),)


def _read_position(endpoint: MatterEndpoint) -> PlainValue:
    closed = _position(endpoint, DIMENSION, _PANEL_STATE)
    return round(100 - closed / 100, 2) if closed is not None and closed <= 10_000 else None


def _write_position(
    endpoint: MatterEndpoint, value: PlainValue, _transition: float, _code: str
) -> tuple[MatterOrder, ...]:
    closed = 10_000 - round(require_number("position", value, 0.0, 100.0, "%") * 100)
    payload: dict[str, object] = {"position": closed}
    if endpoint.features(DIMENSION) & _LATCHES:
        payload["latch"] = False  # a panel that is latched does not move
    return (ClusterInvocation(DIMENSION, "SetTarget", payload, is_timed=True),)


def _position(endpoint: MatterEndpoint, cluster: int, attribute: int) -> int | None:
    state = endpoint.value(cluster, attribute)
    position = state.get("0", state.get("position")) if isinstance(state, dict) else None
    return position if type(position) is int and position >= 0 else None
