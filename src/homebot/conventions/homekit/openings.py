"""The services of what opens, closes and guards: locks, doors, windows, coverings, valves, security systems. Pure.

Source: HomeKit Accessory Protocol Specification R2, 8.11 (Door), 8.16 (Garage Door Opener), 8.26 (Lock Mechanism), 8.33
(Security System), 8.41 (Valve), 8.42 (Window), 8.43 (Window Covering).
"""

from __future__ import annotations

from typing import Final

from homebot.conventions.command_values import require_number, require_option
from homebot.conventions.homekit.accessory import HapService
from homebot.conventions.homekit.rows import ServiceRow, Writes, known_values
from homebot.devices.value import PlainValue

__all__ = ["OPENING_ROWS"]

GARAGE, LOCK, ALARM, COVERING = "41", "45", "7E", "8C"
_MOTORS: Final = f"81 8B {COVERING}"
"""Doors, windows and coverings."""

_VALVES: Final = "D0 D7 CF"
"""Valves, faucets and irrigation systems."""

LOCK_STATE, LOCK_TARGET, POSITION, POSITION_TARGET, MOVEMENT, HOLD = "1D", "1E", "6D", "7C", "72", "6F"
ALARM_STATE, ALARM_TARGET, ACTIVE, IN_USE = "66", "67", "B0", "D2"
_LOCKED: Final = {0: "unlocked", 1: "locked"}
_LOCK_STATES: Final = {**_LOCKED, 2: "jammed"}
_LOCK_WORDS: Final = (*_LOCK_STATES.values(), "locking", "unlocking")
_DOOR_WORDS: Final = ("open", "closed", "opening", "closing", "stopped")
"""By the state of a garage door."""

_ARMED: Final = {0: "armed_home", 1: "armed_away", 2: "armed_night", 3: "disarmed"}
_DISARMED, _TRIGGERED = 3, 4
_MOVES: Final = ("open", "closed", "opening", "closing")
_CLOSED_ANGLE: Final = 90.0
"""Degrees by which slats turn from open (0) to closed, to either side."""


def _read_lock(service: HapService) -> PlainValue:
    state, target = service.number(LOCK_STATE), service.number(LOCK_TARGET)
    if {state, target} == {0.0, 1.0}:
        return "locking" if target else "unlocking"
    return None if state is None else _LOCK_STATES.get(int(state))


def _read_door(service: HapService) -> PlainValue:
    state = service.number("E")
    return dict(enumerate(_DOOR_WORDS)).get(-1 if state is None else int(state))


def _read_movement(service: HapService) -> PlainValue:
    movement, position = service.number(MOVEMENT), service.number(POSITION)
    if movement in {0, 1}:
        return "opening" if movement else "closing"
    return None if position is None else "open" if position else "closed"


def _movements(service: HapService) -> tuple[str, ...]:
    return (*_MOVES, "stopped") if service.can(HOLD, "pw") else _MOVES


def _write_movement(service: HapService, value: PlainValue) -> Writes:
    option = require_option("movement", value, tuple(one for one in _movements(service) if not one.endswith("ing")))
    return {HOLD: 1} if option == "stopped" else {POSITION_TARGET: 100 if option == "open" else 0}


def _tilt_row(state: str, target: str) -> ServiceRow:
    def read(service: HapService) -> PlainValue:
        angle = service.number(state)
        return None if angle is None or abs(angle) > _CLOSED_ANGLE else round(100 - abs(angle) / 0.9, 1)

    def write(service: HapService, value: PlainValue) -> Writes:
        angle = _CLOSED_ANGLE * (1 - require_number("tilt", value, 0.0, 100.0, "%") / 100)
        is_negative = (service.number(state) or 0) < 0 or service.characteristics[target].bounds[1:] == (0.0,)
        return {target: -angle if is_negative else angle}

    return ServiceRow(COVERING, "tilt", state, target, None, read, write)


def _read_alarm(service: HapService) -> PlainValue:
    state, target = service.number(ALARM_STATE), service.number(ALARM_TARGET)
    if state is None or target is None or state == _TRIGGERED:
        return None if state is None else "triggered"
    if state == target:
        return _ARMED.get(int(state))
    return "disarming" if target == _DISARMED else "arming"


def _alarm_options(service: HapService) -> tuple[str, ...]:
    return (*known_values(service, ALARM_TARGET, _ARMED).values(), "triggered", "arming", "disarming")


def _read_valve(service: HapService) -> PlainValue:
    active, in_use = service.number(ACTIVE), service.number(IN_USE)
    if active is None or in_use in {None, active}:
        return None if active is None else "open" if active else "closed"
    return "opening" if active else "closing"


def _write_valve(_at: HapService, value: PlainValue) -> Writes:
    return {ACTIVE: float(require_option("valve", value, ("open", "closed")) == "open")}


OPENING_ROWS: Final = (
    ServiceRow(
        f"{LOCK} {GARAGE}",
        "lock",
        f"{LOCK_STATE} {LOCK_TARGET}",
        LOCK_TARGET,
        _LOCKED,
        _read_lock,
        options=lambda _: _LOCK_WORDS,
    ),
    ServiceRow(GARAGE, "movement", "E", "32", {0: "open", 1: "closed"}, _read_door, options=lambda _: _DOOR_WORDS),
    ServiceRow(_MOTORS, "position", POSITION, POSITION_TARGET),
    ServiceRow(
        _MOTORS,
        "movement",
        f"{POSITION} {MOVEMENT}",
        POSITION_TARGET,
        None,
        _read_movement,
        _write_movement,
        _movements,
    ),
    _tilt_row("6C", "7B"),  # horizontal slats
    _tilt_row("6E", "7D"),  # vertical slats
    ServiceRow(f"{_MOTORS} {GARAGE}", "problem", "24"),  # obstructed
    ServiceRow(_VALVES, "valve", f"{ACTIVE} {IN_USE}", ACTIVE, None, _read_valve, _write_valve, lambda _: _MOVES),
    ServiceRow(
        ALARM,
        "alarm",
        f"{ALARM_STATE} {ALARM_TARGET}",
        ALARM_TARGET,
        _ARMED,
        _read_alarm,
        options=_alarm_options,
    ),
)
