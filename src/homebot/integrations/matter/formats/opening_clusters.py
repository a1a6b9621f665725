"""The clusters of things that open and close: Window Covering, Door Lock, Valve, and closures since Matter 1.5. Pure.

Matter counts how far a covering is closed, the vocabulary how far it is open. A closure, such as a garage door, opens
and closes as a whole; its panels, endpoints of their own, have positions.

Source: Matter 1.4 Application Clusters, 5.2 (Door Lock), 5.3 (Window Covering), 4.6 (Valve); Matter 1.5, 5.4 (Closure
Control), 5.5 (Closure Dimension).
"""

import base64
from functools import partial
from typing import Final

from homebot.conventions.command_values import require_option
from homebot.conventions.payload import as_fields
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import WrongCodeError
from homebot.integrations.matter.formats.cluster_row import any_bit, choice, cluster_row
from homebot.integrations.matter.formats.endpoint import (
    ClusterInvocation,
    MatterEndpoint,
    MatterOrder,
    MatterOrders,
    field_of,
)
from homebot.support.numbers import whole_number

VALVE, LOCK, COVERING, CLOSURE, DIMENSION = 129, 257, 258, 260, 261

_MOVES = ("open", "closed", "opening", "closing", "stopped")
_STATUS, _LIFT, _TILT = 10, (14, 8), (15, 9)
"""The shares are in hundredths of a percent, or in percent."""

_HAS_LIFT, _KNOWS_LIFT, _KNOWS_TILT = 1 << 0, 1 << 2, 1 << 4
_COVERING_COMMANDS: Final = {"open": "UpOrOpen", "closed": "DownOrClose", "stopped": "StopMotion"}

_LOCK_STATE, _DOOR_STATE, _NEEDS_PIN = 0, 3, 0x33
_LOCK_STATES: Final = {0: "unlocked", 1: "locked", 2: "unlocked", 3: "open"}
_DOOR_STATES: Final = {0: True, 1: False, 3: True, 5: True}
_HAS_DOOR, _CAN_UNBOLT = 1 << 5, 1 << 12

_VALVE_STATE, _VALVE_TARGET, _VALVE_LEVEL, _VALVE_FAULT = 4, 5, 6, 9
_HAS_LEVEL: Final = 1 << 1

_MAIN_STATE, _CLOSURE_STATE, _CLOSURE_TARGET, _PANEL_STATE = 1, 3, 4, 0
_POSITIONS, _LATCHES, _INSTANT = 1 << 0, 1 << 1, 1 << 2
_LATCH_MODES: Final = {CLOSURE: 5, DIMENSION: 11}
_REMOTE_LATCHING, _REMOTE_UNLATCHING = 1 << 0, 1 << 1
_MOVING, _CLOSED, _STOP = 1, 0, 0
_MOVE_TO: Final = {"closed": 0, "open": 1}
_COVERING_TAG: Final = (0x44, 0)
_TILT_TAG: Final = (0x45, 1)
"""The tag of a panel with turning slats."""


def is_covering(endpoint: MatterEndpoint) -> bool:
    """Return whether its tags say that it is a blind, shutter or awning rather than a door, gate or window."""
    return _COVERING_TAG in endpoint.tags


def _open_percent(endpoint: MatterEndpoint, hundredths: int, percent: int) -> float | None:
    closed = endpoint.number(COVERING, hundredths, 0, 10_000)
    if closed is not None:
        return round(100 - closed / 100, 2)
    closed = endpoint.number(COVERING, percent, 0, 100)
    return None if closed is None else 100 - closed


def _to_closed_share(percent: float) -> int:
    """Return the hundredths of a percent by which a covering is closed that is open by *percent*."""
    return 10_000 - round(percent * 100)


def _write_share(name: str, field_name: str, _at: MatterEndpoint, command: Command) -> MatterOrders:
    return (ClusterInvocation(COVERING, name, {field_name: _to_closed_share(command.value.number)}),)


def _read_covering_movement(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    status, features = endpoint.whole(COVERING, _STATUS), endpoint.features(COVERING)
    if status is None:
        return None
    if status & 3 in {1, 2}:
        return "opening" if status & 3 == 1 else "closing"
    lift = _open_percent(endpoint, *_LIFT) if features & _KNOWS_LIFT else None
    if lift is None and features & _KNOWS_TILT and not features & _HAS_LIFT:
        lift = _open_percent(endpoint, *_TILT)
    return "stopped" if lift is None else "closed" if lift == 0 else "open"


def _covering_orders(_at: MatterEndpoint) -> dict[str, MatterOrder]:
    return {move: ClusterInvocation(COVERING, name) for move, name in _COVERING_COMMANDS.items()}


def _lock_commands(endpoint: MatterEndpoint) -> dict[str, str]:
    if endpoint.features(LOCK) & _CAN_UNBOLT:
        return {"locked": "LockDoor", "unlocked": "UnboltDoor", "open": "UnlockDoor"}
    return {"locked": "LockDoor", "unlocked": "UnlockDoor"}


def _write_lock(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    commands, code = _lock_commands(endpoint), command.code
    name = commands[require_option("lock", command.value.text, commands)]
    if not code and endpoint.flag(LOCK, _NEEDS_PIN):
        raise WrongCodeError.missing("the lock")
    payload = {"PINCode": base64.b64encode(code.encode()).decode()} if code else {}
    return (ClusterInvocation(LOCK, name, payload, is_timed=True, is_secret=bool(code)),)


def _read_valve(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    state = endpoint.whole(VALVE, _VALVE_STATE)
    if state == 2:
        return {0: "closing", 1: "opening"}.get(endpoint.whole(VALVE, _VALVE_TARGET) or 0)
    return {0: "closed", 1: "open"}.get(-1 if state is None else state)


def _valve_orders(_at: MatterEndpoint) -> dict[str, MatterOrder]:
    return {"open": ClusterInvocation(VALVE, "Open"), "closed": ClusterInvocation(VALVE, "Close")}


def _write_flow(_at: MatterEndpoint, command: Command) -> MatterOrders:
    if percent := round(command.value.number):
        return (ClusterInvocation(VALVE, "Open", {"targetLevel": percent}),)
    return (ClusterInvocation(VALVE, "Close"),)


def _closure_moves(endpoint: MatterEndpoint) -> tuple[str, ...]:
    stops = endpoint.accepts(CLOSURE, _STOP) and not endpoint.features(CLOSURE) & _INSTANT
    return _MOVES if stops else _MOVES[:-1]


def _position(state: object) -> int | None:
    position = whole_number(field_of(as_fields(state), 0, "position"))
    return position if position is not None and position >= 0 else None


def _read_closure_movement(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    position, target = (
        _position(endpoint.value(CLOSURE, attribute)) for attribute in (_CLOSURE_STATE, _CLOSURE_TARGET)
    )
    if endpoint.whole(CLOSURE, _MAIN_STATE) == _MOVING:
        return None if target is None else "closing" if target == _CLOSED else "opening"
    return None if position is None else "closed" if position == _CLOSED else "open"


def _closure_orders(endpoint: MatterEndpoint) -> dict[str, MatterOrder]:
    orders: dict[str, MatterOrder] = {}
    for option, position in _MOVE_TO.items():
        payload = {"position": position, **_latch(endpoint, CLOSURE, latches=option == "closed")}
        orders[option] = ClusterInvocation(CLOSURE, "MoveTo", payload, is_timed=True)
    return orders | {"stopped": ClusterInvocation(CLOSURE, "Stop")}


def _latch(endpoint: MatterEndpoint, cluster: int, *, latches: bool) -> dict[str, bool]:
    """Return the field that latches or unlatches; empty if it has no latch, or only people at it do that."""
    modes = endpoint.whole(cluster, _LATCH_MODES[cluster])
    can = modes is None or modes & (_REMOTE_LATCHING if latches else _REMOTE_UNLATCHING)
    return {"latch": latches} if can and endpoint.features(cluster) & _LATCHES else {}


def _read_panel(_at: MatterEndpoint, state: object) -> PlainValue:
    closed = _position(state)
    return round(100 - closed / 100, 2) if closed is not None and closed <= 10_000 else None


def _write_panel(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    latch = _latch(endpoint, DIMENSION, latches=False)  # a latched panel does not move
    payload = {"position": _to_closed_share(command.value.number), **latch}
    return (ClusterInvocation(DIMENSION, "SetTarget", payload, is_timed=True),)


def _tilts(endpoint: MatterEndpoint) -> bool:
    return _TILT_TAG in endpoint.tags


_WRITE_LIFT: Final = partial(_write_share, "GoToLiftPercentage", "liftPercent100thsValue")
_WRITE_TILT: Final = partial(_write_share, "GoToTiltPercentage", "tiltPercent100thsValue")

OPENING_ROWS: Final = (
    cluster_row(
        COVERING, None, "position", lambda endpoint, _raw: _open_percent(endpoint, *_LIFT), _WRITE_LIFT, _KNOWS_LIFT
    ),
    cluster_row(
        COVERING, None, "tilt", lambda endpoint, _raw: _open_percent(endpoint, *_TILT), _WRITE_TILT, _KNOWS_TILT
    ),
    cluster_row(COVERING, None, "movement", _read_covering_movement, orders=_covering_orders, options=_MOVES),
    cluster_row(
        LOCK,
        _LOCK_STATE,
        "lock",
        choice(_LOCK_STATES),
        _write_lock,
        options=lambda endpoint: tuple(_lock_commands(endpoint)),
        code=lambda endpoint: "digits" if endpoint.flag(LOCK, _NEEDS_PIN) else "",
    ),
    cluster_row(
        LOCK,
        _DOOR_STATE,
        "contact",
        choice(_DOOR_STATES),
        None,
        _HAS_DOOR,
        lambda endpoint: endpoint.has(LOCK, _LOCK_STATE),
    ),
    cluster_row(VALVE, _VALVE_STATE, "valve", _read_valve, orders=_valve_orders, options=_MOVES[:-1]),
    cluster_row(
        VALVE,
        _VALVE_STATE,
        "position",
        lambda endpoint, _raw: endpoint.number(VALVE, _VALVE_LEVEL, 0, 100),
        _write_flow,
        _HAS_LEVEL,
    ),
    cluster_row(VALVE, _VALVE_FAULT, "problem", any_bit()),  # it is stuck, leaks or is not connected
    cluster_row(
        CLOSURE,
        _CLOSURE_STATE,
        "movement",
        _read_closure_movement,
        feature=_POSITIONS,
        orders=_closure_orders,
        options=_closure_moves,
    ),
    cluster_row(DIMENSION, _PANEL_STATE, "tilt", _read_panel, _write_panel, _POSITIONS, _tilts),
    cluster_row(
        DIMENSION,
        _PANEL_STATE,
        "position",
        _read_panel,
        _write_panel,
        _POSITIONS,
        lambda endpoint: not _tilts(endpoint),
    ),
)
