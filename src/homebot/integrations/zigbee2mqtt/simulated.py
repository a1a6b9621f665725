"""Zigbee devices behind Zigbee2MQTT with default settings and availability switched on.

The bridge lists its devices on ``BASE/bridge/devices``. A device publishes its whole state as JSON on
``BASE/NAME``, not retained, and again when it is asked on ``BASE/NAME/get``; it takes commands on ``BASE/NAME/set``.

Source: Zigbee2MQTT 2.14, guide "MQTT topics and messages".
"""

from collections.abc import Callable, Mapping, Sequence

from homebot.house.dialect import Bridge, DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.wire import (
    as_json,
    as_object,
    as_text,
    device_orders,
    hardware_address,
    mired_kelvin,
    scaled,
)
from homebot.support.numbers import to_number

PUBLISHED = 1
SETTABLE = 2
GETTABLE = 4
FULL = PUBLISHED | SETTABLE | GETTABLE


def _expose(kind: str, name: str, access: int, **more: object) -> dict[str, object]:
    return {"type": kind, "name": name, "property": name, "label": name, "access": access, **more}


_COVER: tuple[dict[str, object], ...] = (
    {
        "type": "cover",
        "features": [
            _expose("enum", "state", PUBLISHED | SETTABLE, values=["OPEN", "CLOSE", "STOP"]),
            _expose("numeric", "position", FULL, unit="%", value_min=0, value_max=100),
        ],
    },
    _expose("enum", "moving", PUBLISHED, values=["UP", "STOP", "DOWN"]),
)

EXPOSES: Mapping[str, tuple[dict[str, object], ...]] = {
    "lamp": (
        {
            "type": "light",
            "features": [
                _expose("binary", "state", FULL, value_on="ON", value_off="OFF"),
                _expose("numeric", "brightness", FULL, value_min=0, value_max=254),
                _expose("numeric", "color_temp", FULL, unit="mired", value_min=112, value_max=666),
            ],
        },
    ),
    "window": _COVER,
    "cover": _COVER,
    "lock": (
        {
            "type": "lock",
            "features": [
                _expose("binary", "state", FULL, value_on="LOCK", value_off="UNLOCK"),
                _expose("enum", "lock_state", PUBLISHED, values=["not_fully_locked", "locked", "unlocked"]),
            ],
        },
    ),
    "contact": (_expose("binary", "contact", PUBLISHED, value_on=False, value_off=True),),
    "motion": (_expose("binary", "occupancy", PUBLISHED, value_on=True, value_off=False),),
    "presence": (_expose("binary", "presence", PUBLISHED, value_on=True, value_off=False),),
    "lux": (_expose("numeric", "illuminance", PUBLISHED, unit="lx"),),
    "power_meter": (
        _expose("numeric", "power", PUBLISHED, unit="W"),
        _expose("numeric", "energy", PUBLISHED, unit="kWh"),
    ),
    "thermostat": (
        {
            "type": "climate",
            "features": [
                _expose(
                    "numeric",
                    "occupied_heating_setpoint",
                    FULL,
                    unit="°C",
                    value_min=5,
                    value_max=30,
                    value_step=0.5,
                ),
                _expose("numeric", "local_temperature", PUBLISHED | GETTABLE, unit="°C"),
                _expose("enum", "system_mode", FULL, values=["heat"]),
                _expose("enum", "running_state", PUBLISHED | GETTABLE, values=["idle", "heat"]),
            ],
        },
    ),
}
"""By kind."""


LEVELS = 254
MIRED = 1e6


class Zigbee2MqttDialect(Dialect):
    """Devices of one bridge: all kinds but robots."""

    kinds = frozenset(EXPOSES)

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return where it takes commands and questions."""
        topic = _topic(device)
        return (f"{topic}/set", f"{topic}/set/+", f"{topic}/get")

    def availability(self, device: SimulatedDeviceInfo) -> tuple[str, bytes, bytes]:
        """Return the topic on which the bridge reports sooner or later that it is offline."""
        return f"{_topic(device)}/availability", b'{"state":"online"}', b'{"state":"offline"}'

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its whole state."""
        return (OutgoingMessage(_topic(device), as_json(_STATES[device.kind](state))),)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the command in a payload: an object of properties, one value, or a text for its state."""
        base, _, rest = topic.removeprefix(_topic(device)).removeprefix("/").partition("/")
        if base != "set":
            return ()
        wanted = {rest or "state": as_text(payload), **({} if rest else as_object(payload))}
        state = str(wanted.get("state", ""))
        return device_orders(
            device.kind,
            is_on={"on": True, "off": False}.get(state.lower()),
            brightness=scaled(wanted.get("brightness"), LEVELS),
            kelvin=mired_kelvin(wanted.get("color_temp")),
            position=scaled(wanted.get("position"), 100),
            action=state if device.kind != "lock" or state.isupper() else "",
            target=to_number(wanted.get("occupied_heating_setpoint")),
        )

    def replies(
        self, device: SimulatedDeviceInfo, state: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return its state where it was asked for."""
        del payload
        return self.state_messages(device, state) if topic == f"{_topic(device)}/get" else ()

    def bridge(self, devices: Sequence[SimulatedDeviceInfo]) -> Bridge:
        """Return the bridge, which knows itself and *devices*."""
        home = devices[0].home if devices else ""
        itself = {
            "ieee_address": _ieee(SimulatedDeviceInfo(home, "bridge", "coordinator", "bridge", "")),
            "type": "Coordinator",
            "friendly_name": "Coordinator",
            "supported": False,
            "disabled": False,
            "interview_state": "SUCCESSFUL",
            "definition": None,
        }
        listed = as_json([itself, *(_entry(device) for device in devices)])
        state = "zigbee2mqtt/bridge/state"
        return Bridge(
            birth=(
                OutgoingMessage(state, b'{"state":"online"}', retain=True),
                OutgoingMessage("zigbee2mqtt/bridge/devices", listed, retain=True),
            ),
            will=OutgoingMessage(state, b'{"state":"offline"}', retain=True),
        )


def _topic(device: SimulatedDeviceInfo) -> str:
    return f"zigbee2mqtt/{device.device_id}"


def _entry(device: SimulatedDeviceInfo) -> dict[str, object]:
    return {
        "ieee_address": _ieee(device),
        "type": "Router" if device.kind in {"lamp", "cover", "window"} else "EndDevice",
        "friendly_name": device.device_id,
        "supported": True,
        "disabled": False,
        "interview_state": "SUCCESSFUL",
        "definition": {
            "model": f"SIM-{device.kind}",
            "vendor": "homebot",
            "description": f"Simulated {device.kind}",
            "exposes": EXPOSES[device.kind],
            "options": [],
        },
    }


def _ieee(device: SimulatedDeviceInfo) -> str:
    return f"0x{hardware_address(device, 16)}"


def _cover_state(motor: DeviceState) -> dict[str, object]:
    return {
        "state": "OPEN" if motor.position else "CLOSE",
        "position": round(motor.position * 100),
        "moving": {1: "UP", -1: "DOWN"}.get(motor.way, "STOP"),
    }


def _lamp_state(lamp: DeviceState) -> dict[str, object]:
    return {
        "state": "ON" if lamp.is_on else "OFF",
        "brightness": max(1, round(lamp.brightness * LEVELS)),
        "color_mode": "color_temp",
        "color_temp": round(MIRED / lamp.kelvin),
    }


def _lock_state(lock: DeviceState) -> dict[str, object]:
    where = lock.text if lock.text in {"locked", "unlocked"} else "not_fully_locked"
    return {"state": "LOCK" if lock.text == "locked" else "UNLOCK", "lock_state": where}


def _thermostat_state(thermostat: DeviceState) -> dict[str, object]:
    return {
        "local_temperature": round(thermostat.celsius, 1),
        "occupied_heating_setpoint": round(thermostat.target, 3),
        "system_mode": "heat",
        "running_state": "heat" if thermostat.heats else "idle",
    }


_STATES: Mapping[str, Callable[[DeviceState], dict[str, object]]] = {
    "lamp": _lamp_state,
    "window": _cover_state,
    "cover": _cover_state,
    "lock": _lock_state,
    "contact": lambda door: {"contact": door.text != "open"},
    "motion": lambda room: {"occupancy": room.text == "motion"},
    "presence": lambda room: {"presence": room.text == "motion"},
    "lux": lambda lux: {"illuminance": lux.value},
    "power_meter": lambda meter: {"power": meter.value, "energy": round(meter.kilowatt_hours, 3)},
    "thermostat": _thermostat_state,
}
