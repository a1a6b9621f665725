"""The clusters of lamps: On/Off, Level Control and Color Control. Pure.

Source: Matter 1.4 Application Clusters, 1.5 (On/Off), 1.6 (Level Control), 3.2 (Color Control).
"""

from collections.abc import Iterable
from typing import Final

from homebot.conventions.capability_row import writer_of
from homebot.conventions.command_values import require_transition
from homebot.conventions.lamp import LIGHT_CAPABILITIES
from homebot.conventions.light_color import MIRED, from_hue_saturation, nearest_mired_bounds, to_hue_saturation
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.integrations.matter.formats.cluster_row import ClusterRow, cluster_row, flag
from homebot.integrations.matter.formats.endpoint import ClusterInvocation, MatterEndpoint, MatterOrders

ON_OFF, LEVEL, LOCK, COLOR = 6, 8, 257, 768

_ON_OFF_VALUE = 0
_OFF_ONLY: Final = 1 << 2
_CURRENT_LEVEL, _MIN_LEVEL, _MAX_LEVEL = 0, 2, 3
_HUE, _SATURATION, _X, _Y, _MIREDS, _COLOR_MODE = 0, 1, 3, 4, 7, 8
_ENHANCED_HUE, _ENHANCED_MODE, _CAPABILITIES, _MIN_MIREDS, _MAX_MIREDS = 0x4000, 0x4001, 0x400A, 0x400B, 0x400C
_HAS_HUE, _HAS_ENHANCED_HUE, _HAS_XY, _HAS_MIREDS = 1 << 0, 1 << 1, 1 << 3, 1 << 4
_MODE_XY, _MODE_MIREDS = 1, 2

_SPEAKER, _PUMP = 0x0022, 0x0303
_ONLY_SWITCHED: Final = frozenset({0x0100, 0x010A, 0x010F, _SPEAKER})
_DIMMED: Final = frozenset({0x0101, 0x010B, 0x010C, 0x010D, 0x0110})
"""Lights, plugs and mounted controls. Those not dimmed may have a level that does nothing, as Inovelli's VTM30 has."""

_WHITES: Final = (2000, 6500)
_MAX_COLOR: Final = 65_279
_TURN_ON: Final = ClusterInvocation(ON_OFF, "On")

_MAX_TRANSITION_S: Final = 6553.0
"""Seconds of a transition: tenths of them in 16 bits."""

_ALSO_WHEN_OFF: Final = {"optionsMask": 1, "optionsOverride": 1}
"""ExecuteIfOff: a lamp that is off takes the new colour, and is turned on after it."""

_NO_OPTIONS: Final = {"optionsMask": 0, "optionsOverride": 0}


def _is_speaker(endpoint: MatterEndpoint) -> bool:
    return _SPEAKER in endpoint.device_types


def _is_dimmed(endpoint: MatterEndpoint) -> bool:
    types = endpoint.device_types
    return not _DIMMED.isdisjoint(types) or _ONLY_SWITCHED.isdisjoint(types)


def _color_features(endpoint: MatterEndpoint) -> int:
    return endpoint.features(COLOR) or endpoint.whole(COLOR, _CAPABILITIES) or 0


def _has_colors(endpoint: MatterEndpoint) -> int:
    return _color_features(endpoint) & (_HAS_HUE | _HAS_XY)


def _write_on(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    if command.value.flag and endpoint.features(ON_OFF) & _OFF_ONLY:
        raise RefusedError("on_off true", "the device can only be turned off, as a cooktop for safety")
    return (ClusterInvocation(ON_OFF, "On" if command.value.flag else "Off"),)


def _levels(endpoint: MatterEndpoint) -> tuple[int, int]:
    """Return the lowest and the highest level; 0 is none, as it means off."""
    full = 200 if _PUMP in endpoint.device_types else 254  # a pump counts in half percent
    most = endpoint.whole(LEVEL, _MAX_LEVEL)
    most = most if most is not None and 1 <= most <= full else full
    least = endpoint.whole(LEVEL, _MIN_LEVEL)
    return (min(max(least, 1), most) if least is not None else 1), most


def _read_level(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    level = endpoint.number(LEVEL, _CURRENT_LEVEL, 0, 254)
    return None if level is None else min(round(level * 100 / _levels(endpoint)[1], 2), 100.0)


def _write_level(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    percent, (least, most) = command.value.number, _levels(endpoint)
    level = max(least, round(percent * most / 100)) if percent > 0 else 0
    payload = {"level": level, "transitionTime": _tenths(command), **_NO_OPTIONS}
    has_switch = endpoint.has(ON_OFF) and not _is_speaker(endpoint)
    return (ClusterInvocation(LEVEL, "MoveToLevelWithOnOff" if has_switch else "MoveToLevel", payload),)


def _mired_range(endpoint: MatterEndpoint) -> tuple[float, float]:
    least, most = endpoint.number(COLOR, _MIN_MIREDS), endpoint.number(COLOR, _MAX_MIREDS)
    if least is None or most is None or not 25 <= least < most <= 1000:
        return MIRED / _WHITES[1], MIRED / _WHITES[0]
    return least, most


def _mode(endpoint: MatterEndpoint) -> int | None:
    mode = endpoint.whole(COLOR, _ENHANCED_MODE)
    return endpoint.whole(COLOR, _COLOR_MODE) if mode is None else mode


def _read_kelvin(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    mireds = endpoint.number(COLOR, _MIREDS, 1, _MAX_COLOR)
    if mireds is None or (_has_colors(endpoint) and _mode(endpoint) != _MODE_MIREDS):
        return None
    return float(round(MIRED / mireds))


def _write_kelvin(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    least, most = _mired_range(endpoint)
    mireds = round(min(max(MIRED / command.value.number, least), most))
    return _move_color(endpoint, "MoveToColorTemperature", command, colorTemperatureMireds=mireds)


def _read_color(endpoint: MatterEndpoint, _raw: object) -> PlainValue:
    mode = _mode(endpoint)
    if mode == _MODE_MIREDS:
        return None
    if mode == _MODE_XY or not _color_features(endpoint) & _HAS_HUE:
        x, y = (endpoint.number(COLOR, attribute, 0, _MAX_COLOR) for attribute in (_X, _Y))
        return None if x is None or y is None else to_hue_saturation("xy", (x / 65_536, y / 65_536), _WHITES)
    degrees, saturation = None, endpoint.number(COLOR, _SATURATION, 0, 254)
    if (enhanced := endpoint.number(COLOR, _ENHANCED_HUE, 0, 65_535)) is not None:
        degrees = enhanced * 360 / 65_536
    elif (hue := endpoint.number(COLOR, _HUE, 0, 254)) is not None:
        degrees = hue * 360 / 254
    return None if degrees is None or saturation is None else (round(degrees, 2), round(saturation * 100 / 254, 2))


def _write_color(endpoint: MatterEndpoint, command: Command) -> MatterOrders:
    hue, saturation = command.value.numbers
    features = _color_features(endpoint)
    if not features & _HAS_HUE:
        x, y = (min(round(share * 65_536), _MAX_COLOR) for share in from_hue_saturation("xy", hue, saturation, _WHITES))
        return _move_color(endpoint, "MoveToColor", command, colorX=x, colorY=y)
    strength = round(saturation * 254 / 100)
    if features & _HAS_ENHANCED_HUE:
        turn = round(hue * 65_536 / 360) % 65_536
        return _move_color(endpoint, "EnhancedMoveToHueAndSaturation", command, enhancedHue=turn, saturation=strength)
    return _move_color(endpoint, "MoveToHueAndSaturation", command, hue=round(hue * 254 / 360), saturation=strength)


def _move_color(endpoint: MatterEndpoint, name: str, command: Command, **fields: int) -> MatterOrders:
    """Return the order of a colour, which turns no lamp on, and that to turn a lamp with a switch on."""
    payload = {**fields, "transitionTime": _tenths(command), **_ALSO_WHEN_OFF}
    switched = (_TURN_ON,) if endpoint.has(ON_OFF, _ON_OFF_VALUE) else ()
    return (ClusterInvocation(COLOR, name, payload), *switched)


def joint_orders(
    rows: Iterable[ClusterRow], endpoint: MatterEndpoint, command: Command
) -> tuple[MatterOrders, tuple[str, ...]]:
    """Return the orders of *command*, and of its further settings if it is for a lamp, with the names of these.

    Colours take effect while the lamp is off, and the level turns it on, so that it shines at once as it shall.
    """
    first, *others = command.singly()
    further = [other for other in others if {other.capability, first.capability} <= LIGHT_CAPABILITIES]
    rows = tuple(rows)
    orders = [
        order for setting in (first, *further) for order in writer_of(rows, setting.capability)(endpoint, setting)
    ]
    if further:
        lit = sorted((order for order in orders if order != _TURN_ON), key=lambda order: order.cluster != COLOR)
        orders = (
            lit if any(order.cluster == LEVEL for order in lit) else [*lit, *(_TURN_ON,) * (len(lit) < len(orders))]
        )
    return tuple(orders), tuple([setting.capability for setting in further])


def _tenths(command: Command) -> int:
    return round(require_transition(command.transition, _MAX_TRANSITION_S) * 10)


LIGHT_ROWS: Final = (
    # On/Off of a lock may move its bolt, and that of a speaker mutes it (Matter 1.4 Device Library, Speaker).
    cluster_row(
        ON_OFF,
        _ON_OFF_VALUE,
        "muted",
        flag(means=False),
        lambda _at, command: (ClusterInvocation(ON_OFF, "Off" if command.value.flag else "On"),),
        when=_is_speaker,
    ),
    cluster_row(
        ON_OFF,
        _ON_OFF_VALUE,
        "on_off",
        flag(),
        _write_on,
        when=lambda endpoint: not endpoint.has(LOCK) and not _is_speaker(endpoint),
    ),
    cluster_row(LEVEL, _CURRENT_LEVEL, "volume", _read_level, _write_level, when=_is_speaker),
    cluster_row(LEVEL, _CURRENT_LEVEL, "level", _read_level, _write_level, when=_is_dimmed),
    cluster_row(
        COLOR,
        None,
        "color_temperature",
        _read_kelvin,
        _write_kelvin,
        when=lambda endpoint: _color_features(endpoint) & _HAS_MIREDS,
        bounds=lambda endpoint: nearest_mired_bounds(*_mired_range(endpoint)),
    ),
    cluster_row(COLOR, None, "color", _read_color, _write_color, when=_has_colors),
)
