"""The clusters of appliances: modes, temperatures, operational states, pumps, vacuum cleaners and car chargers. Pure.

Source: Matter 1.4 Application Clusters, 1.9 (Mode Select), 1.10 (Mode Base), 1.14 (Operational State), 1.17 (Service
Area), 4.2 (Pump), 6.10 (Media Playback), 7.2 to 7.4 (RVC), 8 (home appliances, among them 8.2, Temperature Control, and
8.4, Dishwasher Alarm), 9.3 (Energy EVSE), 9.5 (Water Heater); Matter 1.5, Chime.
"""

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import islice
from typing import Final

from homebot.conventions.command_values import require_true
from homebot.conventions.payload import as_fields, clean_text, text_of
from homebot.conventions.units import number_grid
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.integrations.matter.formats.cluster_row import (
    ClusterRow,
    any_bit,
    choice,
    choice_row,
    cluster_row,
    number,
    one_of,
)
from homebot.integrations.matter.formats.endpoint import (
    ACCEPTED_COMMANDS,
    ClusterInvocation,
    MatterEndpoint,
    MatterOrder,
    MatterOrders,
    field_of,
)
from homebot.support.numbers import whole_number

MODE: Final = "mode"
"""The part of an endpoint that is a setting with a name of its own: of a light, a button or nothing else."""

MODE_SELECT, RUN_MODE, TEMPERATURE, OPERATION, CLEANING, EVSE = 80, 84, 86, 96, 97, 153
OVEN_CAVITY, OVEN_MODE, FRIDGE_ALARM, WATER_HEATER, HEATER_MODE, PUMP = 72, 73, 87, 148, 158, 512
WASHER, _SPIN, _RINSE, ENERGY_MODE, PLAYBACK, SERVICE_AREA = 83, 1, 2, 159, 0x0506, 336
DISHWASHER_ALARM, CHIME, _SELECTED_SOUND = 93, 0x0556, 1
MICROWAVE, _COOK_TIME, _MAX_COOK_TIME = 95, 0, 1
_RINSES: Final = {0: "none", 1: "normal", 2: "extra", 3: "most"}
_CHARGES, _FAULT, _IS_OPEN = 3, 6, 1
_SUPPLY, _CIRCUIT_CURRENT, _MIN_CURRENT, _ENABLE_CHARGING = 1, 5, 6, 2
_MODE_CLUSTERS: Final = (MODE_SELECT, OVEN_MODE, 81, 82, 85, 89, 94, 157, HEATER_MODE, ENERGY_MODE)
"""Plain, oven, laundry washer, refrigerator, vacuum cleaner, dishwasher, microwave oven, charger, water heater, energy:
the plain and the energy's are parts beside the mode that operates an endpoint."""

_CHANGE_TO_MODE: Final = 0
_MAX_MODES: Final = 100
_SETPOINT, _LIMITS, _STEP, _LEVEL, _LEVELS = 0, (1, 2), 3, 4, 5
_BY_NUMBER: Final = 1 << 0
_ANY_CELSIUS: Final = (-273.15, 327.67)

_STATE: Final = 4
_STOPPED, _RUNNING, _PAUSED, _ERROR = 0, 1, 2, 3
_VACUUM_STATES: Final = {_PAUSED: "paused", _ERROR: "error", 0x40: "returning", 0x41: "docked", 0x42: "docked"}
_VACUUM_OPTIONS: Final = ("cleaning", "paused", "idle", "returning", "docked", "error")
_IDLE_TAG, _CLEANING_TAG, _MAPPING_TAG = 0x4000, 0x4001, 0x4002
_VACUUM_COMMANDS: Final = {"paused": (0, "Pause"), "returning": (128, "GoHome")}
_RESUME: Final = 3
_AREAS, _SELECTED, _SELECT_AREAS = 0, 2, 0
_EVERYWHERE: Final = "everywhere"
_PLAYER_COMMANDS: Final = {"playing": (0, "Play"), "paused": (1, "Pause"), "stopped": (2, "Stop")}


def is_oven_cabinet(endpoint: MatterEndpoint) -> bool:
    """Return whether it is the inside of an oven; that of a refrigerator has the same device type."""
    return endpoint.has(OVEN_CAVITY) or endpoint.has(OVEN_MODE)


def _current_attribute(cluster: int) -> int:
    return 3 if cluster == MODE_SELECT else 1


def _modes(endpoint: MatterEndpoint, cluster: int) -> Iterator[tuple[int, str, tuple[int, ...]]]:
    """Yield number, label and standard tags of each supported mode."""
    for struct in endpoint.structs(cluster, 2 if cluster == MODE_SELECT else 0):
        label, mode = field_of(struct, 0, "label"), whole_number(field_of(struct, 1, "mode"))
        if isinstance(label, str) and mode is not None:
            listed = field_of(struct, 2, "modeTags")
            tags = [tag for tag in (listed if isinstance(listed, list) else []) if isinstance(tag, dict)]
            values = [whole_number(field_of(tag, 1, "value")) for tag in tags]
            yield mode, clean_text(label), tuple(value for value in values if value is not None)


def _labels(cluster: int, endpoint: MatterEndpoint) -> dict[int, str]:
    modes: dict[int, str] = {}
    for mode, label, _ in _modes(endpoint, cluster):
        if label and len(modes) < _MAX_MODES:
            modes[mode] = label
    return modes


def _change_to_mode(cluster: int, mode: int) -> ClusterInvocation:
    return ClusterInvocation(cluster, "ChangeToMode", {"newMode": mode})


def _mode_row(cluster: int) -> ClusterRow:
    capability = "water_heater_mode" if cluster == HEATER_MODE else "option"
    labels, order = partial(_labels, cluster), partial(_change_to_mode, cluster)
    return replace(
        choice_row(cluster, _current_attribute(cluster), labels, order, capability, accepts=_CHANGE_TO_MODE),
        part=MODE if cluster == MODE_SELECT else "",
        spare_part="energy_mode" if cluster == ENERGY_MODE else "",
    )


def _temperature_bounds(endpoint: MatterEndpoint) -> tuple[float, float]:
    least, most = (endpoint.number(TEMPERATURE, limit) for limit in _LIMITS)
    return (least / 100, most / 100) if least is not None and most is not None and least < most else _ANY_CELSIUS


def _to_temperature(target: str, value: int) -> ClusterInvocation:
    return ClusterInvocation(TEMPERATURE, "SetTemperature", {target: value})


def _levels(endpoint: MatterEndpoint) -> dict[int, str]:
    """Return the names of temperature levels; none if the temperature is a number."""
    return {} if endpoint.features(TEMPERATURE) & _BY_NUMBER else _texts(endpoint.value(TEMPERATURE, _LEVELS))


def _texts(listed: object) -> dict[int, str]:
    texts = (clean_text(text) for text in listed if isinstance(text, str)) if isinstance(listed, list) else ()
    return dict(enumerate(texts))


def _rinses(endpoint: MatterEndpoint) -> dict[int, str]:
    listed = endpoint.value(WASHER, 3)
    return {raw: name for raw, name in _RINSES.items() if isinstance(listed, list) and raw in listed}


def _button_row(number_: int, name: str, cluster: int = OPERATION, part: str = "") -> ClusterRow:
    """Return the row of a command, such as of an operation, which is a part beside it."""

    def write(_at: MatterEndpoint, command: Command) -> MatterOrders:
        require_true("push", command.value.plain())
        return (ClusterInvocation(cluster, name),)

    return cluster_row(
        cluster,
        ACCEPTED_COMMANDS,
        "push",
        write=write,
        when=lambda endpoint: endpoint.accepts(cluster, number_),
        part=part or name.casefold(),
    )


def _sounds(endpoint: MatterEndpoint) -> dict[int, str]:
    """Return the installed sounds of a chime, by number."""
    listed = islice(endpoint.structs(CHIME, 0), _MAX_MODES)
    chimes = ((whole_number(field_of(chime, 0, "chimeID")), text_of(field_of(chime, 1, "name"))) for chime in listed)
    return {number_: name for number_, name in chimes if number_ is not None and name}


def _read_vacuum(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    state = endpoint.whole(CLEANING, _STATE)
    if state in _VACUUM_STATES:
        return _VACUUM_STATES[state]
    current = endpoint.whole(RUN_MODE, _current_attribute(RUN_MODE))
    tags = next((tags for mode, _, tags in _modes(endpoint, RUN_MODE) if mode == current), ())
    if _CLEANING_TAG in tags or _MAPPING_TAG in tags:
        return "cleaning"
    return "idle" if _IDLE_TAG in tags else {_RUNNING: "cleaning", _STOPPED: "idle"}.get(-1 if state is None else state)


def _vacuum_orders(endpoint: MatterEndpoint) -> dict[str, MatterOrder]:
    tagged = {tag: mode for mode, _, tags in reversed(list(_modes(endpoint, RUN_MODE))) for tag in tags}
    orders: dict[str, MatterOrder] = {
        option: ClusterInvocation(CLEANING, name)
        for option, (number_, name) in _VACUUM_COMMANDS.items()
        if endpoint.accepts(CLEANING, number_)
    }
    for option, tag in (("cleaning", _CLEANING_TAG), ("idle", _IDLE_TAG)):
        if tag in tagged:
            orders[option] = _change_to_mode(RUN_MODE, tagged[tag])
    if endpoint.whole(CLEANING, _STATE) == _PAUSED and endpoint.accepts(CLEANING, _RESUME):
        orders["cleaning"] = ClusterInvocation(CLEANING, "Resume")
    return orders


def _areas(endpoint: MatterEndpoint) -> dict[str, list[int]]:
    """Return the selection that cleans each area, by its name, and that without one, which cleans all; {} for none."""
    areas_by_name: dict[str, list[int]] = {}
    for area in endpoint.structs(SERVICE_AREA, _AREAS):
        number_ = whole_number(field_of(area, 0, "areaID"))
        place = as_fields(field_of(as_fields(field_of(area, 2, "areaInfo")), 0, "locationInfo"))
        if number_ is not None and len(areas_by_name) < _MAX_MODES:
            name = text_of(field_of(place, 0, "locationName"))
            areas_by_name[name if name and name not in areas_by_name else f"{name or 'Area'} {number_}"] = [number_]
    return {_EVERYWHERE: [], **areas_by_name} if areas_by_name else {}


def _write_charging(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    """Return the order to charge without an end, at most with the current of the circuit, or not to charge."""
    if not command.value.flag:
        return (ClusterInvocation(EVSE, "Disable", is_timed=True),)
    least, most = (endpoint.whole(EVSE, attribute) or 0 for attribute in (_MIN_CURRENT, _CIRCUIT_CURRENT))
    currents = {"minimumChargeCurrent": least, "maximumChargeCurrent": most}
    return (ClusterInvocation(EVSE, "EnableCharging", {"chargingEnabledUntil": None, **currents}, is_timed=True),)


APPLIANCE_ROWS: Final = (
    *map(_mode_row, _MODE_CLUSTERS),
    cluster_row(
        TEMPERATURE,
        None,
        "number",
        lambda endpoint, _raw: number(100)(endpoint, endpoint.value(TEMPERATURE, _SETPOINT)),
        lambda _at, command: (_to_temperature("targetTemperature", round(command.value.number * 100)),),
        _BY_NUMBER,
        bounds=_temperature_bounds,
        grid=lambda endpoint: number_grid(
            _temperature_bounds(endpoint)[0], (endpoint.number(TEMPERATURE, _STEP) or 0) / 100
        ),
        unit="°C",
    ),
    replace(
        choice_row(TEMPERATURE, _LEVEL, _levels, partial(_to_temperature, "targetTemperatureLevel")),
        spare_part="temperature",
    ),
    replace(choice_row(WASHER, _SPIN, lambda endpoint: _texts(endpoint.value(WASHER, 0))), spare_part="spin_speed"),
    replace(choice_row(WASHER, _RINSE, _rinses), spare_part="rinses"),
    cluster_row(
        MICROWAVE,
        _COOK_TIME,
        "number",
        number(),
        lambda _at, command: (
            ClusterInvocation(MICROWAVE, "SetCookingParameters", {"cookTime": round(command.value.number)}),
        ),
        bounds=lambda endpoint: (1, endpoint.number(MICROWAVE, _MAX_COOK_TIME, 1) or 86_400),
        unit="s",
        part="cook_time",
    ),
    cluster_row(OPERATION, _STATE, "running", one_of(_RUNNING)),
    cluster_row(OPERATION, _STATE, "problem", one_of(_ERROR)),
    *(_button_row(number_, name) for number_, name in enumerate(("Pause", "Stop", "Start", "Resume"))),
    cluster_row(OVEN_CAVITY, _STATE, "running", one_of(_RUNNING)),
    cluster_row(OVEN_CAVITY, _STATE, "problem", one_of(_ERROR)),
    cluster_row(
        CLEANING,
        _STATE,
        "vacuum",
        _read_vacuum,
        when=lambda endpoint: endpoint.has(RUN_MODE, _current_attribute(RUN_MODE)),
        orders=_vacuum_orders,
        options=_VACUUM_OPTIONS,
        also_read=RUN_MODE,
    ),
    cluster_row(
        SERVICE_AREA,
        _SELECTED,
        "option",
        lambda endpoint, raw: next((name for name, areas in _areas(endpoint).items() if areas == raw), None),
        when=_areas,
        orders=lambda endpoint: {
            name: ClusterInvocation(SERVICE_AREA, "SelectAreas", {"newAreas": areas})
            for name, areas in _areas(endpoint).items()
        },
        accepts=_SELECT_AREAS,
        spare_part="area",
    ),
    cluster_row(
        PLAYBACK,
        0,
        "playback",
        choice({0: "playing", 1: "paused", 2: "stopped", 3: "buffering"}),
        orders=lambda endpoint: {
            state: ClusterInvocation(PLAYBACK, name)
            for state, (number_, name) in _PLAYER_COMMANDS.items()
            if endpoint.accepts(PLAYBACK, number_)
        },
    ),
    cluster_row(EVSE, _SUPPLY, "on_off", one_of(1, 5), _write_charging, accepts=_ENABLE_CHARGING),
    cluster_row(EVSE, 0, "plugged_in", choice({state: state != 0 for state in range(_FAULT)})),  # a fault says nothing
    cluster_row(EVSE, 0, "running", one_of(_CHARGES)),
    cluster_row(EVSE, 0, "problem", one_of(_FAULT)),
    cluster_row(EVSE, 48, "battery", number(1, 0, 100)),  # of the car
    cluster_row(PUMP, 16, "running", any_bit(1 << 5)),
    cluster_row(PUMP, 16, "problem", any_bit(0b11)),  # of itself, or of its supply
    cluster_row(WATER_HEATER, 4, "measurement", number(1, 0, 100), unit="%"),  # how much of the water is hot
    cluster_row(FRIDGE_ALARM, 2, "problem", one_of(_IS_OPEN)),
    cluster_row(DISHWASHER_ALARM, 2, "problem", any_bit(), spare_part="alarm"),  # of water, heat or door
    choice_row(CHIME, _SELECTED_SOUND, _sounds, None, "siren_tone"),
    _button_row(0, "PlayChimeSound", CHIME, "play"),
)
