"""Devices with Tasmota's firmware, which announce themselves on ``tasmota/discovery/MAC``.

A device with the topic ``T`` publishes its state on ``tele/T/STATE`` or ``tele/T/SENSOR``, again when it is asked on
``cmnd/T/STATE`` or ``cmnd/T/STATUS``, and its availability on ``tele/T/LWT``; it takes commands on ``cmnd/T/…``.

Source: Tasmota documentation, "MQTT" and "Commands", firmware 14; hatasmota 0.10 for the announcement.
"""

from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.wire import (
    as_json,
    as_text,
    device_orders,
    hardware_address,
    mired_kelvin,
    node_name,
    scaled,
)
from homebot.support.numbers import to_number

COLDEST, WARMEST = 153, 500
"""Mired, as far as a Tasmota lamp goes."""

RELAYS = {"lamp": (2,), "window": (3, 3), "cover": (3, 3)}
SWITCHES = frozenset({"contact", "motion"})
SENSORS = {"lux": ("BH1750", "Illuminance"), "power_meter": ("ENERGY", "Power")}


class TasmotaDialect(Dialect):
    """Lamps, motors, contacts, motion sensors, light sensors and meters with Tasmota's default topics."""

    kinds = frozenset({*RELAYS, *SWITCHES, *SENSORS})

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return where it takes commands."""
        return (f"cmnd/{node_name(device)}/+",)

    def availability(self, device: SimulatedDeviceInfo) -> tuple[str, bytes, bytes]:
        """Return the topic of its last will."""
        return f"tele/{node_name(device)}/LWT", b"Online", b"Offline"

    def announcement(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return its two announcements, kept."""
        mac = hardware_address(device).upper()
        sensors: dict[str, object] = {"Switch1": "OFF"} if device.kind in SWITCHES else {}
        if device.kind in SENSORS:
            chip, quantity = SENSORS[device.kind]
            sensors = {chip: {quantity: 0}}
        messages = {"config": _config(device, mac), "sensors": {"sn": sensors, "ver": 1}}
        return tuple(
            OutgoingMessage(f"tasmota/discovery/{mac}/{name}", as_json(message), retain=True)
            for name, message in messages.items()
        )

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its state, as in each period."""
        if device.kind in SENSORS or device.kind in SWITCHES:
            return (OutgoingMessage(f"tele/{node_name(device)}/SENSOR", as_json(_reading(device, state))),)
        if device.kind == "lamp":
            mireds = min(max(round(1e6 / state.kelvin), COLDEST), WARMEST)
            power = "ON" if state.is_on else "OFF"
            report = {"POWER": power, "Dimmer": round(state.brightness * 100), "CT": mireds}
            return (OutgoingMessage(f"tele/{node_name(device)}/STATE", as_json(report)),)
        return (OutgoingMessage(f"stat/{node_name(device)}/RESULT", as_json(_shutter(state))),)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the meaning of a command, or of each in a ``Backlog``."""
        name, value = topic.rpartition("/")[2].lower(), as_text(payload)
        if name.rstrip("0123456789") != "backlog":
            return _parse(device.kind, name, value)
        orders = (order.strip().partition(" ") for order in value.split(";"))
        return tuple(text for order, _, wanted in orders for text in _parse(device.kind, order.lower(), wanted.strip()))

    def replies(
        self, device: SimulatedDeviceInfo, state: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return its state where ``STATE``, its readings where ``STATUS 10`` was asked for."""
        name = topic.rpartition("/")[2].lower()
        if name == "state" and device.kind == "lamp":
            return self.state_messages(device, state)
        if name.startswith("shutterposition") and device.kind in RELAYS and not payload:
            return self.state_messages(device, state)
        if name == "status" and as_text(payload) == "10":
            reading = _shutter(state) if device.kind in RELAYS else _reading(device, state)
            return (OutgoingMessage(f"stat/{node_name(device)}/STATUS10", as_json({"StatusSNS": reading})),)
        return ()


def _config(device: SimulatedDeviceInfo, mac: str) -> dict[str, object]:
    relays = RELAYS.get(device.kind, ())
    return {
        "ip": "192.0.2.1",
        "dn": device.device_id,
        "fn": [device.device_id, *[None] * 7],
        "hn": node_name(device),
        "mac": mac,
        "md": f"Simulated {device.kind}",
        "ty": 0,
        "if": 0,
        "ofln": "Offline",
        "onln": "Online",
        "state": ["OFF", "ON", "TOGGLE", "HOLD"],
        "sw": "14.4.1",
        "t": node_name(device),
        "ft": "%prefix%/%topic%/",
        "tp": ["cmnd", "stat", "tele"],
        "rl": [*relays, *[0] * (32 - len(relays))],
        "swc": [1 if device.kind in SWITCHES else -1, *[-1] * 27],
        "swn": [None] * 28,
        "btn": [0] * 32,
        "so": {"4": 0, "11": 0, "13": 0, "17": 0, "20": 0, "30": 0, "68": 0, "73": 0, "82": 0, "114": 1, "117": 0},
        "lk": 1,
        "lt_st": 2 if device.kind == "lamp" else 0,
        "sho": [0] * 4,
        "sht": [[0, 0, 0]] * 4,
        "bat": 0,
        "dslp": 0,
        "ver": 1,
    }


def _reading(device: SimulatedDeviceInfo, state: DeviceState) -> dict[str, object]:
    if device.kind in SENSORS:
        chip, quantity = SENSORS[device.kind]
        return {chip: {quantity: state.value}}
    return {"Switch1": "ON" if state.text in {"open", "motion"} else "OFF"}


def _shutter(motor: DeviceState) -> dict[str, object]:
    return {"Shutter1": {"Position": round(motor.position * 100), "Direction": motor.way}}


def _parse(kind: str, name: str, value: str) -> tuple[str, ...]:
    name = name.rstrip("0123456789")
    return device_orders(
        kind,
        is_on={"on": True, "1": True, "off": False, "0": False}.get(value.lower()) if name == "power" else None,
        brightness=scaled(value, 100) if name == "dimmer" else None,
        kelvin=mired_kelvin(value) if name == "ct" else None,
        position=scaled(value, 100) if name == "shutterposition" else None,
        action=name.removeprefix("shutter") if to_number(value) is None else "",
    )
