"""The clusters of things that open and close: Window Covering, Door Lock, Valve Configuration and Control. Pure.

Matter counts how far a covering is closed, the vocabulary how far it is open.

Source: Matter 1.4 Application Clusters, 5.2 (Door Lock), 5.3 (Window Covering), 4.6 (Valve).
"""

from __future__ import annotations

import base64
from collections.abc import Iterator
from typing import Final

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.matter.endpoint import ClusterInvocation, MatterAbility, MatterEndpoint, MatterOrder
from homebot.devices.part import Capability
from homebot.devices.value import PlainValue
from homebot.errors import WrongCodeError

__all__ = ["opening_abilities"]

LOCK, COVERING, VALVE = 257, 258, 129

_MOVES = ("open", "closed", "opening", "closing", "stopped")
_STATUS, _LIFT, _TILT = 10, 14, 15
_LIFT_PERCENT, _TILT_PERCENT = 8, 9
_HAS_LIFT, _KNOWS_LIFT, _KNOWS_TILT = 1 << 0, 1 << 2, 1 << 4
_COVERING_COMMANDS: Final = {"open": "UpOrOpen", "closed": "DownOrClose", "stopped": "StopMotion"}

_LOCK_STATE, _DOOR_STATE, _NEEDS_PIN = 0, 3, 0x33
_LOCK_STATES: Final = {0: "unlocked", 1: "locked", 2: "unlocked", 3: "open"}
_DOOR_STATES: Final = {0: True, 1: False, 3: True, 5: True}
_HAS_DOOR, _CAN_UNBOLT = 1 << 5, 1 << 12

_VALVE_STATE, _VALVE_TARGET, _VALVE_LEVEL = 4, 5, 6
_HAS_LEVEL: Final = 1 << 1


def opening_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    """Yield position, movement, lock and valve, as the endpoint has them."""
    if endpoint.has(COVERING):
        yield from _covering_abilities(endpoint)
    if endpoint.has(LOCK, _LOCK_STATE):
        can_unbolt = endpoint.features(LOCK) & _CAN_UNBOLT
        options = ("locked", "unlocked", "open") if can_unbolt else ("locked", "unlocked")
        yield MatterAbility(LOCK, Capability(name="lock", settable=True, options=options), _read_lock, _write_lock)
        if endpoint.features(LOCK) & _HAS_DOOR and endpoint.has(LOCK, _DOOR_STATE):
            yield MatterAbility(LOCK, Capability(name="contact"), _read_door)
    if endpoint.has(VALVE, _VALVE_STATE):
        capability = Capability(name="valve", settable=True, options=("open", "closed", "opening", "closing"))
        yield MatterAbility(VALVE, capability, _read_valve, _write_valve)
        if endpoint.features(VALVE) & _HAS_LEVEL:
            yield MatterAbility(VALVE, Capability(name="position", settable=True), _read_flow, _write_flow)


def _covering_abilities(endpoint: MatterEndpoint) -> Iterator[MatterAbility]:
    features = endpoint.features(COVERING)
    if features & _KNOWS_LIFT:
        yield MatterAbility(COVERING, Capability(name="position", settable=True), _read_lift, _write_lift)
    if features & _KNOWS_TILT:
        yield MatterAbility(COVERING, Capability(name="tilt", settable=True), _read_tilt, _write_tilt)
    capability = Capability(name="movement", settable=True, options=_MOVES)
    yield MatterAbility(COVERING, capability, _read_movement, _write_movement)


def _open_percent(endpoint: MatterEndpoint, hundredths: int, percent: int) -> float | None:
    closed = endpoint.number(COVERING, hundredths)
    if closed is not None and 0 <= closed <= 10_000:
        return round(100 - closed / 100, 2)
    closed = endpoint.number(COVERING, percent)
    return 100 - closed if closed is not None and 0 <= closed <= 100 else None


def _read_lift(endpoint: MatterEndpoint) -> PlainValue:
    return _open_percent(endpoint, _LIFT, _LIFT_PERCENT)


def _read_tilt(endpoint: MatterEndpoint) -> PlainValue:
    return _open_percent(endpoint, _TILT, _TILT_PERCENT)


def _write_lift(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    closed = _closed_hundredths("position", value)
    return (ClusterInvocation(COVERING, "GoToLiftPercentage", {"liftPercent100thsValue": closed}),)


def _write_tilt(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    closed = _closed_hundredths("tilt", value)
    return (ClusterInvocation(COVERING, "GoToTiltPercentage", {"tiltPercent100thsValue": closed}),)


def _closed_hundredths(capability: str, value: PlainValue) -> int:
    return 10_000 - round(require_number(capability, value, 0.0, 100.0, "%") * 100)


def _read_movement(endpoint: MatterEndpoint) -> PlainValue:
    status = endpoint.whole(COVERING, _STATUS)
    if status is None:
        return None
    if (moves := {1: "opening", 2: "closing"}.get(status & 3)) is not None:
        return moves
    lift = _read_lift(endpoint) if endpoint.features(COVERING) & _KNOWS_LIFT else None
    if lift is None and endpoint.features(COVERING) & _KNOWS_TILT and not endpoint.features(COVERING) & _HAS_LIFT:
        lift = _read_tilt(endpoint)
    if lift is None:
        return "stopped"
    return "closed" if lift == 0 else "open"


def _write_movement(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    option = require_option("movement", value, _COVERING_COMMANDS)
    return (ClusterInvocation(COVERING, _COVERING_COMMANDS[option]),)


def _read_lock(endpoint: MatterEndpoint) -> PlainValue:
    state = endpoint.whole(LOCK, _LOCK_STATE)
    return None if state is None else _LOCK_STATES.get(state)


def _read_door(endpoint: MatterEndpoint) -> PlainValue:
    state = endpoint.whole(LOCK, _DOOR_STATE)
    return None if state is None else _DOOR_STATES.get(state)


def _write_lock(endpoint: MatterEndpoint, value: PlainValue, _transition: float, code: str) -> tuple[MatterOrder, ...]:
    can_unbolt = bool(endpoint.features(LOCK) & _CAN_UNBOLT)
    commands = {"locked": "LockDoor", "unlocked": "UnboltDoor" if can_unbolt else "UnlockDoor"}
    if can_unbolt:
        commands["open"] = "UnlockDoor"
    command = commands[require_option("lock", value, commands)]
    if not code and endpoint.flag(LOCK, _NEEDS_PIN):
        raise WrongCodeError("the lock", "it requires its PIN code")
    payload = {"PINCode": base64.b64encode(code.encode()).decode()} if code else {}
    return (ClusterInvocation(LOCK, command, payload, is_timed=True, is_secret=bool(code)),)


def _read_valve(endpoint: MatterEndpoint) -> PlainValue:
    state = endpoint.whole(VALVE, _VALVE_STATE)
    if state == 2:
        return {0: "closing", 1: "opening"}.get(endpoint.whole(VALVE, _VALVE_TARGET) or 0)
    return {0: "closed", 1: "open"}.get(-1 if state is None else state)


def _write_valve(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    option = require_option("valve", value, ("open", "closed"))
    return (ClusterInvocation(VALVE, "Open" if option == "open" else "Close"),)


def _read_flow(endpoint: MatterEndpoint) -> PlainValue:
    level = endpoint.number(VALVE, _VALVE_LEVEL)
    return level if level is not None and 0 <= level <= 100 else None


def _write_flow(_at: MatterEndpoint, value: PlainValue, _transition: float, _code: str) -> tuple[MatterOrder, ...]:
    percent = round(require_number("position", value, 0.0, 100.0, "%"))
    if percent == 0:
        return (ClusterInvocation(VALVE, "Close"),)
    return (ClusterInvocation(VALVE, "Open", {"targetLevel": percent}),)
