"""The services of what opens, closes and guards: locks, doors, windows, coverings, valves, security systems. Pure.

Source: HomeKit Accessory Protocol Specification R2, 8.11 (Door), 8.16 (Garage Door Opener), 8.26 (Lock Mechanism), 8.33
(Security System), 8.41 (Valve), 8.42 (Window), 8.43 (Window Covering).
"""

from collections.abc import Mapping
from typing import Final

from homebot.conventions.command_values import require_option
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.integrations.homekit.formats.accessory import HapService
from homebot.integrations.homekit.formats.rows import ServiceRow, Writes, known_values, service_row

GARAGE, COVERING = "41", "8C"
_MOTORS: Final = f"81 8B {COVERING}"
"""Doors, windows and coverings."""

_VALVES: Final = "D0 D7"
"""Valves and faucets."""

IRRIGATION: Final = "CF"

POSITION, POSITION_TARGET, MOVEMENT, HOLD = "6D", "7C", "72", "6F"
_LOCKED: Final = {0: "unlocked", 1: "locked"}
_OPENED: Final = {0: "closed", 1: "open"}
_OPEN: Final = {0: "open", 1: "closed"}
_DOOR_MOVES: Final = {2: "opening", 3: "closing", 4: "stopped"}
_ARMED: Final = {0: "armed_home", 1: "armed_away", 2: "armed_night", 3: "disarmed"}
_MOVES: Final = ("open", "closed", "opening", "closing")
_ORDERS: Final = {"open": {POSITION_TARGET: 100}, "closed": {POSITION_TARGET: 0}, "stopped": {HOLD: 1}}
_CLOSED_ANGLE: Final = 90.0
"""Degrees by which slats turn from open (0) to closed, to either side."""


def _target_row(
    services: str,
    capability: str,
    state: str,
    target: str,
    values: Mapping[int, str],
    moving: Mapping[int, str],
    others: Mapping[int, str],
) -> ServiceRow:
    """Return the row of a state that follows a target.

    Args:
        values: The texts of both.
        moving: The texts, by the target, while they differ.
        others: The texts of further states.
    """

    def read(service: HapService) -> PlainValue:
        now, wanted = service.number(state), service.number(target)
        if now is not None and wanted is not None and now != wanted and {now, wanted} <= values.keys():
            return moving[int(wanted)]
        return None if now is None else {**values, **others}.get(int(now))

    def options(service: HapService) -> tuple[str, ...]:
        return tuple(
            dict.fromkeys([*known_values(service, target, values).values(), *others.values(), *moving.values()])
        )

    return service_row(services, capability, f"{state} {target}", target, values, read, options=options)


def _read_movement(service: HapService) -> PlainValue:
    movement, position = service.number(MOVEMENT), service.number(POSITION)
    if movement in {0, 1} and position != service.number(POSITION_TARGET):  # some never say that they stopped
        return "opening" if movement else "closing"
    return None if position is None else "open" if position else "closed"


def _write_movement(_at: HapService, command: Command) -> Writes:
    return _ORDERS[require_option("movement", command.value.text, _ORDERS)]


def _tilt_row(state: str, target: str) -> ServiceRow:
    def read(service: HapService) -> PlainValue:
        angle = service.number(state)
        return None if angle is None or abs(angle) > _CLOSED_ANGLE else round(100 - abs(angle) / 0.9, 1)

    def write(service: HapService, command: Command) -> Writes:
        angle = _CLOSED_ANGLE * (1 - command.value.number / 100)
        is_negative = (service.number(state) or 0) < 0 or service.characteristics[target].bounds[1:] == (0.0,)
        return {target: -angle if is_negative else angle}

    return service_row(COVERING, "tilt", state, target, None, read, write, grid=lambda _: ())


OPENING_ROWS: Final = (
    _target_row(f"45 {GARAGE}", "lock", "1D", "1E", _LOCKED, {0: "unlocking", 1: "locking"}, {2: "jammed"}),
    _target_row(
        "7E", "alarm", "66", "67", _ARMED, dict.fromkeys(range(3), "arming") | {3: "disarming"}, {4: "triggered"}
    ),
    _target_row(_VALVES, "valve", "D2", "B0", _OPENED, {0: "closing", 1: "opening"}, {}),
    service_row(_VALVES, "valve", "B0", "B0", _OPENED),  # a faucet
    service_row(_VALVES, "number", "D3", "D3", unit="s"),  # for how long it opens
    service_row(IRRIGATION, "on_off", "B0", "B0"),  # whether its programs may water
    service_row(IRRIGATION, "running", "D2"),
    _target_row(GARAGE, "movement", "E", "32", _OPEN, {0: "opening", 1: "closing"}, _DOOR_MOVES),
    service_row(_MOTORS, "position", POSITION, POSITION_TARGET),
    service_row(
        _MOTORS,
        "movement",
        f"{POSITION} {MOVEMENT} {POSITION_TARGET}",
        POSITION_TARGET,
        None,
        _read_movement,
        _write_movement,
        lambda service: (*_MOVES, "stopped") if service.can(HOLD, "pw") else _MOVES,
    ),
    _tilt_row("6C", "7B"),  # horizontal slats
    _tilt_row("6E", "7D"),  # vertical slats
    service_row(f"{_MOTORS} {GARAGE}", "problem", "24"),  # obstructed
)
