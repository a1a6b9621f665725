"""The clusters of heating and air: Thermostat and Fan Control. Pure.

A preset of a thermostat, such as *Home* and *Away*, is a named temperature.

Source: Matter 1.4 Application Clusters, 4.3 (Thermostat; 4.3.9, presets), 4.4 (Fan Control), 4.5
(Thermostat User Interface Configuration).
"""

from functools import partial
from typing import Final

from homebot.conventions.payload import text_of
from homebot.conventions.units import percent_grid
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.integrations.matter.formats.cluster_row import (
    ClusterRow,
    any_bit,
    choice,
    choice_row,
    cluster_row,
    number,
    number_writer,
)
from homebot.integrations.matter.formats.endpoint import (
    AttributeWrite,
    ClusterInvocation,
    MatterEndpoint,
    MatterOrder,
    MatterOrders,
    field_of,
)
from homebot.integrations.matter.formats.light_clusters import ON_OFF
from homebot.support.numbers import whole_number

THERMOSTAT, FAN, KEYPAD, _LOCKOUT = 513, 514, 516, 1

_LOCAL, _OUTDOOR, _HEATING_DEMAND, _OFFSET, _COOLING, _HEATING = 0, 1, 8, 0x10, 0x11, 0x12
_SYSTEM_MODE, _RUNNING_STATE, _ACTIVE_PRESET, _PRESETS = 0x1C, 0x29, 0x4E, 0x50
_LIMITS: Final = {_HEATING: ((0x15, 0x16), (3, 4)), _COOLING: ((0x17, 0x18), (5, 6))}
"""The attributes of each setpoint's limits: those that people set, and those of the device."""

_USUAL_LIMITS: Final = {_HEATING: (7.0, 30.0), _COOLING: (16.0, 32.0)}
_HEATS, _COOLS, _CHANGES_BY_ITSELF, _HAS_PRESETS = 1 << 0, 1 << 1, 1 << 5, 1 << 8
_CONTROL_SEQUENCE: Final = 0x1B
_SEQUENCE_FEATURES: Final = {0: 2, 1: 2, 2: 1, 3: 1, 4: 3, 5: 3}
"""By the control sequence, of devices without a feature map."""

_MODE_NAMES: Final = ("off", "auto", "", "cool", "heat", "emergency_heat", "precooling", "fan_only", "dry", "sleep")
_MODES: Final = {number: name for number, name in enumerate(_MODE_NAMES) if name}
_MODE_NUMBERS: Final = {name: number for number, name in _MODES.items()}
_SETTABLE_MODES: Final = (("heat", _HEATS), ("cool", _COOLS), ("auto", _CHANGES_BY_ITSELF))
_ROOM_AIR_CONDITIONER, _MORE_MODES = 0x0072, ("fan_only", "dry")
"""No feature tells whether it has these modes, which Home Assistant lists by product; one without them refuses."""

_ACTIONS: Final = ((0b0_1001, "heating"), (0b1_0010, "cooling"), (0b110_0100, "fan"))
_SCENARIOS: Final = {1: "occupied", 2: "unoccupied", 3: "sleep", 4: "wake", 5: "vacation", 6: "going_to_sleep"}
_MAX_PRESETS: Final = 50
_MAX_HANDLE_CHARACTERS: Final = 64

_FAN_MODE, _FAN_SEQUENCE, _FAN_SETTING, _FAN_PERCENT, _ROCK_SUPPORT, _ROCK, _AIRFLOW = 0, 1, 2, 3, 7, 8, 11
_FAN_SPEEDS = 4
_FAN_MODES: Final = dict(enumerate(("off", "low", "medium", "high", "on", "auto", "smart")))
_FAN_NUMBERS: Final = {name: number for number, name in _FAN_MODES.items()}
_HIGH: Final = 3
_SEQUENCES: Final = {
    0: ("off", "low", "medium", "high"),
    1: ("off", "low", "high"),
    2: ("off", "low", "medium", "high", "auto"),
    3: ("off", "low", "high", "auto"),
    4: ("off", "high", "auto"),
    5: ("off", "high"),
}
_ROCKS, _TURNS_AROUND = 1 << 2, 1 << 5
_DIRECTIONS: Final = {0: "forward", 1: "reverse"}


def _setpoint_bounds(attribute: int, endpoint: MatterEndpoint) -> tuple[float, float]:
    for limits in _LIMITS[attribute]:
        least, most = (endpoint.number(THERMOSTAT, limit, -32_767, 32_767) for limit in limits)
        if least is not None and most is not None and least < most:
            return least / 100, most / 100
    return _USUAL_LIMITS[attribute]


def _mode_orders(endpoint: MatterEndpoint) -> dict[str, MatterOrder]:
    sequence = endpoint.whole(THERMOSTAT, _CONTROL_SEQUENCE) or 0
    features = endpoint.features(THERMOSTAT) or _SEQUENCE_FEATURES.get(sequence, 0)
    modes = ("off", *(mode for mode, feature in _SETTABLE_MODES if features & feature))
    modes += _MORE_MODES if _ROOM_AIR_CONDITIONER in endpoint.device_types else ()
    return {mode: AttributeWrite(THERMOSTAT, _SYSTEM_MODE, _MODE_NUMBERS[mode]) for mode in modes}


def _read_action(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    state = endpoint.whole(THERMOSTAT, _RUNNING_STATE)
    if state is None:
        return None
    rests = "off" if endpoint.whole(THERMOSTAT, _SYSTEM_MODE) == 0 else "idle"
    return next((action for bits, action in _ACTIONS if state & bits), rests)


def _presets(endpoint: MatterEndpoint) -> dict[str, str]:
    """Return the names of the presets by handle; the server has bytes in Base64."""
    presets: dict[str, str] = {}
    for preset in endpoint.structs(THERMOSTAT, _PRESETS):
        handle = field_of(preset, 0, "presetHandle")
        scenario = whole_number(field_of(preset, 1, "presetScenario"))
        name = text_of(field_of(preset, 2, "name")) or _SCENARIOS.get(scenario or 0, "")
        is_handle = isinstance(handle, str) and 0 < len(handle) <= _MAX_HANDLE_CHARACTERS
        if is_handle and name not in {"", *presets.values()} and len(presets) < _MAX_PRESETS:
            presets[str(handle)] = name
    return presets


def _activate(handle: str) -> MatterOrder:
    return ClusterInvocation(THERMOSTAT, "SetActivePresetRequest", {"presetHandle": handle})


def _write_fan_on(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    if not command.value.flag:
        return (AttributeWrite(FAN, _FAN_MODE, 0),)
    if endpoint.whole(FAN, _FAN_MODE):
        return ()  # it is on; another mode would change its speed
    return (AttributeWrite(FAN, _FAN_MODE, _HIGH),)


def _read_speed(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    if endpoint.whole(FAN, _FAN_MODE) == 0:
        return 0.0  # some keep the speed of before
    percent = endpoint.number(FAN, _FAN_PERCENT, 0, 100)
    return endpoint.number(FAN, _FAN_SETTING, 0, 100) if percent is None else percent


def _fan_orders(endpoint: MatterEndpoint) -> dict[str, MatterOrder]:
    modes = _SEQUENCES.get(endpoint.whole(FAN, _FAN_SEQUENCE) or 0, _SEQUENCES[0])
    return {mode: AttributeWrite(FAN, _FAN_MODE, _FAN_NUMBERS[mode]) for mode in modes}


def _write_rock(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    supported = endpoint.whole(FAN, _ROCK_SUPPORT) or 1
    return (AttributeWrite(FAN, _ROCK, supported if command.value.flag else 0),)


def _setpoint_row(name: str, attribute: int, feature: int) -> ClusterRow:
    return cluster_row(
        THERMOSTAT,
        attribute,
        name,
        number(100, -32_767, 32_767),
        number_writer(THERMOSTAT, attribute, 100),
        when=lambda endpoint: not endpoint.features(THERMOSTAT) or endpoint.features(THERMOSTAT) & feature,
        bounds=partial(_setpoint_bounds, attribute),
    )


CLIMATE_ROWS: Final = (
    cluster_row(THERMOSTAT, _LOCAL, "local_temperature", number(100, -32_767, 32_767)),
    cluster_row(
        THERMOSTAT,
        _OUTDOOR,
        "measurement",
        number(100, -27_315, 32_767),
        unit="°C",
        part="outdoor_temperature",
    ),
    cluster_row(
        THERMOSTAT,
        _OFFSET,
        "number",
        number(10, -127, 127),
        number_writer(THERMOSTAT, _OFFSET, 10),
        bounds=lambda _at: (-12.7, 12.7),
        unit="K",
        part="temperature_offset",
    ),
    cluster_row(
        KEYPAD,
        _LOCKOUT,
        "on_off",
        any_bit(),
        lambda _at, command: (AttributeWrite(KEYPAD, _LOCKOUT, int(command.value.flag)),),
        part="child_lock",
    ),
    cluster_row(THERMOSTAT, _HEATING_DEMAND, "measurement", number(1, 0, 100), unit="%"),  # of the greatest heating
    _setpoint_row("heating_setpoint", _HEATING, _HEATS),
    _setpoint_row("cooling_setpoint", _COOLING, _COOLS),
    cluster_row(THERMOSTAT, _SYSTEM_MODE, "thermostat_mode", choice(_MODES), orders=_mode_orders),
    cluster_row(THERMOSTAT, _RUNNING_STATE, "thermostat_action", _read_action),
    choice_row(THERMOSTAT, _ACTIVE_PRESET, _presets, _activate, "preset_mode", feature=_HAS_PRESETS),
    cluster_row(FAN, _FAN_MODE, "on_off", any_bit(), _write_fan_on, when=lambda endpoint: not endpoint.has(ON_OFF)),
    cluster_row(
        FAN,
        _FAN_SETTING,
        "fan_speed",
        _read_speed,
        lambda _at, command: (AttributeWrite(FAN, _FAN_SETTING, int(command.value.number)),),  # 67 % is 3 speeds of 3
        grid=lambda endpoint: percent_grid(endpoint.number(FAN, _FAN_SPEEDS) or 0),
    ),
    cluster_row(FAN, _FAN_MODE, "fan_mode", choice(_FAN_MODES), orders=_fan_orders),
    cluster_row(FAN, _ROCK, "oscillation", any_bit(), _write_rock, _ROCKS),
    cluster_row(
        FAN,
        _AIRFLOW,
        "direction",
        choice(_DIRECTIONS),
        feature=_TURNS_AROUND,
        orders=lambda _at: {name: AttributeWrite(FAN, _AIRFLOW, number) for number, name in _DIRECTIONS.items()},
    ),
)
