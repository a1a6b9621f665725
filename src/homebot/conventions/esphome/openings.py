"""Covers, valves and locks of ESPHome. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto``.
"""

from __future__ import annotations

from homebot.conventions.command_values import require_option
from homebot.conventions.device_classes import CLOSURE_CLASSES
from homebot.conventions.esphome.entity import EsphomeEntity, Fields, number_of, table_reader, text_of
from homebot.devices.value import PlainValue
from homebot.errors import WrongCodeError

__all__ = ["build_cover", "build_lock", "build_valve"]

_MOVES = {"open": {"position": 1.0}, "closed": {"position": 0.0}}
_OPERATIONS = {1: "opening", 2: "closing"}


def build_cover(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a window covering, or a closure where its class is one."""
    is_closure = text_of(info, "device_class") in CLOSURE_CLASSES
    entity = EsphomeEntity(kind, info, "closure" if is_closure else "window_covering")
    _add_movement(entity, "movement", info)
    if info.get("supports_tilt") is True:
        entity.add_percent("tilt", "tilt")
    return entity


def build_valve(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a valve."""
    entity = EsphomeEntity(kind, info, "water_valve")
    _add_movement(entity, "valve", info)
    return entity


def build_lock(kind: str, info: Fields) -> EsphomeEntity:
    """Describe a lock; the device checks the code if it needs one."""
    commands = {"unlocked": 0, "locked": 1} | ({"open": 2} if info.get("supports_open") is True else {})
    wants_code = info.get("requires_code") is True

    def write(value: PlainValue, code: str) -> Fields:
        command = commands[require_option("lock", value, commands)]
        if wants_code and not code:
            raise WrongCodeError(f"lock {value}", "it needs a code")
        return {"command": command, "code": code} if code else {"command": command}

    entity = EsphomeEntity(kind, info, "door_lock")
    entity.add("lock", table_reader("state", _LOCK_STATES), write)
    return entity


_LOCK_STATES: dict[object, str] = {
    1: "locked",
    2: "unlocked",
    3: "jammed",
    4: "locking",
    5: "unlocking",
    6: "opening",
    7: "open",
}


def _add_movement(entity: EsphomeEntity, name: str, info: Fields) -> None:
    """Add movement, and position if it is measured; otherwise the position is 0 or 1 and shows open or closed."""
    moves: dict[str, Fields] = dict(_MOVES)
    if info.get("supports_stop") is True:
        moves["stopped"] = {"stop": True}

    def read(state: Fields) -> PlainValue:
        operation = state.get("current_operation")
        position = number_of(state, "position")
        if isinstance(operation, int) and operation in _OPERATIONS:
            return _OPERATIONS[operation]
        return None if position is None else "open" if position > 0 else "closed"

    entity.add(name, read, lambda value, _code: moves[require_option(name, value, moves)])
    if info.get("supports_position") is True:
        entity.add_percent("position", "position")
