"""The attributes and commands of simulated Matter devices. Pure.

Source: Matter 1.4 Application Clusters and Device Library.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Final, TypeAlias

from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.wire import device_orders, hardware_address, mired_kelvin, scaled

Attributes: TypeAlias = dict[str, object]
"""Values by cluster and attribute (``6/0``), or by path (``1/6/0``)."""

DEVICE_TYPES: Final[Mapping[str, int]] = {
    "lamp": 0x010C,
    "plug": 0x010A,
    "window": 0x0202,
    "cover": 0x0202,
    "lock": 0x000A,
    "contact": 0x0015,
    "motion": 0x0107,
    "lux": 0x0106,
    "power_meter": 0x0510,
    "thermostat": 0x0301,
}
"""By kind: those of the house, and ``plug``, at which there is a lamp."""

BRIDGED_NODE: Final = 0x0013
SCENES: Final = 98
_LEVELS: Final = 254
_MIREDS: Final = 1e6


def attributes_of(device: SimulatedDeviceInfo, state: DeviceState, kind: str = "") -> Attributes:
    """Return all attributes, by path, of the node that *device* is; of another *kind* where it has one in Matter."""
    return root_attributes(device, [1]) | at_endpoint(1, _endpoint(kind or device.kind, state))


def root_attributes(device: SimulatedDeviceInfo, endpoints: Sequence[int]) -> Attributes:
    """Return the attributes, by path, of the root of a node with these other *endpoints*."""
    return {
        "0/29/0": [{"0": 0x0016, "1": 1}],
        "0/29/3": list(endpoints),
        "0/40/1": "homebot",
        "0/40/3": f"SIM-{device.kind}",
        "0/40/5": device.device_id,
        "0/40/10": "1.0",
        "0/40/15": hardware_address(device, 16),
    }


def bridged_attributes(device: SimulatedDeviceInfo, state: DeviceState, *, is_reachable: bool) -> Attributes:
    """Return the attributes of the endpoint that *device* is behind a bridge."""
    return {
        **_endpoint(device.kind, state),
        "29/0": [{"0": BRIDGED_NODE, "1": 1}, {"0": DEVICE_TYPES[device.kind], "1": 1}],
        "57/1": "homebot",
        "57/3": f"SIM-{device.kind}",
        "57/5": device.device_id,
        "57/15": hardware_address(device, 16),
        "57/17": is_reachable,
    }


def at_endpoint(endpoint: int, attributes: Attributes) -> Attributes:
    """Return attributes of an endpoint by their paths."""
    return {f"{endpoint}/{path}": value for path, value in attributes.items()}


def state_attributes(kind: str, state: DeviceState) -> Attributes:
    """Return the attributes that say how a device of this *kind* is."""
    return _STATES[kind](state)


def command_orders(kind: str, cluster: int, command: str, payload: Mapping[str, object]) -> tuple[str, ...] | None:
    """Return the orders that a command gives a device; None for a command that it does not have."""
    wanted = _COMMANDS.get((cluster, command))
    if wanted is None or not any(path.startswith(f"{cluster}/") for path in _FIXED.get(kind, {})):
        return None
    return wanted("lamp" if kind == "plug" else kind, payload) or None


def write_orders(kind: str, path: str, value: object) -> tuple[str, ...] | None:
    """Return the orders that writing an attribute (``513/18``) gives a device; None where it cannot be written."""
    if kind != "thermostat":
        return None
    return {"513/18": device_orders(kind, target=scaled(value, 100)) or None, "513/28": ()}.get(path)


def scene_fields(attributes: Attributes) -> list[object]:
    """Return the extension field sets of a scene: its attributes by cluster."""
    numbers_by_tag: dict[int, list[object]] = {}
    for path, value in attributes.items():
        cluster, attribute = map(int, path.split("/"))
        size = "valueUnsigned8" if cluster in {6, 8} else "valueUnsigned16"
        pair = {"attributeID": attribute, "valueSigned8": None, size: int(value) if isinstance(value, int) else 0}
        numbers_by_tag.setdefault(cluster, []).append(pair)
    return [{"clusterID": cluster, "attributeValueList": pairs} for cluster, pairs in numbers_by_tag.items()]


def scene_orders(kind: str, attributes: Attributes) -> tuple[str, ...]:
    """Return the orders that recalling a scene with these attributes gives a lamp."""
    lamp = "lamp" if kind == "plug" else kind
    if not attributes.get("6/0"):
        return device_orders(lamp, is_on=False)
    return (*device_orders(lamp, is_on=True), *_obey_level(lamp, {"level": attributes.get("8/0")}))


def _endpoint(kind: str, state: DeviceState) -> Attributes:
    return {
        "3/0": 0,
        "3/1": 2,
        "29/0": [{"0": DEVICE_TYPES[kind], "1": 1}],
        "29/3": [],
        **_FIXED.get(kind, {}),
        **state_attributes(kind, state),
    }


def _obey_level(kind: str, payload: Mapping[str, object]) -> tuple[str, ...]:
    level = scaled(payload.get("level"), _LEVELS)
    return device_orders(kind, is_on=None if level is None else level > 0, brightness=level)


def _obey_lift(kind: str, payload: Mapping[str, object]) -> tuple[str, ...]:
    closed = scaled(payload.get("liftPercent100thsValue"), 10_000)
    return device_orders(kind, position=None if closed is None else 1 - closed)


_COMMANDS: Final[Mapping[tuple[int, str], Callable[[str, Mapping[str, object]], tuple[str, ...]]]] = {
    (6, "On"): lambda kind, _: device_orders(kind, is_on=True),
    (6, "Off"): lambda kind, _: device_orders(kind, is_on=False),
    (8, "MoveToLevelWithOnOff"): _obey_level,
    (257, "LockDoor"): lambda kind, _: device_orders(kind, action="lock"),
    (257, "UnlockDoor"): lambda kind, _: device_orders(kind, action="unlock"),
    (258, "UpOrOpen"): lambda kind, _: device_orders(kind, action="open"),
    (258, "DownOrClose"): lambda kind, _: device_orders(kind, action="close"),
    (258, "StopMotion"): lambda kind, _: device_orders(kind, action="stop"),
    (258, "GoToLiftPercentage"): _obey_lift,
    (768, "MoveToColorTemperature"): lambda kind, payload: device_orders(
        kind, kelvin=mired_kelvin(payload.get("colorTemperatureMireds"))
    ),
}
"""By cluster and command: what gives a device of a kind its orders."""


def _lamp(lamp: DeviceState) -> Attributes:
    return {
        "6/0": lamp.is_on,
        "8/0": max(1, round(lamp.brightness * _LEVELS)),
        "768/7": round(_MIREDS / lamp.kelvin),
    }


def _motor(motor: DeviceState) -> Attributes:
    way = {1: 0b0101, -1: 0b1010}.get(motor.way, 0)
    return {"258/14": round((1 - motor.position) * 10_000), "258/10": way}


def _thermostat(thermostat: DeviceState) -> Attributes:
    return {
        "513/0": round(thermostat.celsius * 100),
        "513/18": round(thermostat.target * 100),
        "513/41": 1 if thermostat.heats else 0,
    }


def _lux(lux: DeviceState) -> Attributes:
    return {"1024/0": min(round(10_000 * math.log10(lux.value) + 1), 0xFFFE) if lux.value >= 1 else 0}


_FIXED: Final[Mapping[str, Attributes]] = {
    "lamp": {
        "6/65532": 1,
        "8/2": 1,
        "8/3": _LEVELS,
        "8/65532": 3,
        "768/8": 2,
        "768/16385": 2,
        "768/16395": 112,
        "768/16396": 666,
        "768/65532": 16,
    },
    "plug": {"6/65532": 0},
    "window": {"258/65532": 0b101},
    "cover": {"258/65532": 0b101},
    "lock": {"257/65532": 0, "257/51": False},
    "thermostat": {"513/3": 500, "513/4": 3000, "513/28": 4, "513/65532": 1},
}

_STATES: Final[Mapping[str, Callable[[DeviceState], Attributes]]] = {
    "lamp": _lamp,
    "plug": lambda lamp: {"6/0": lamp.is_on},
    "window": _motor,
    "cover": _motor,
    "lock": lambda lock: {"257/0": {"locked": 1, "unlocked": 2}.get(lock.text, 0)},
    "contact": lambda door: {"69/0": door.text != "open"},
    "motion": lambda room: {"1030/0": 1 if room.text == "motion" else 0},
    "lux": _lux,
    "power_meter": lambda meter: {"144/8": round(meter.value * 1000)},
    "thermostat": _thermostat,
}
