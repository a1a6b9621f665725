"""Shelly devices of the first generation: they announce themselves when they are born or asked to.

A device ``MODEL-MAC`` publishes below ``shellies/MODEL-MAC``: ``online``, and its component, for example ``light/0``,
``light/0/status`` and ``light/0/command``. The broker keeps only ``online``.

Source: Shelly API documentation, Gen1, "MQTT".
"""

from collections.abc import Mapping
from dataclasses import dataclass

from homebot.house.dialect import DeviceState, Dialect, OutgoingMessage, SimulatedDeviceInfo
from homebot.house.simulated_device import number_text
from homebot.house.wire import as_json, as_object, as_text, device_orders, hardware_address, scaled
from homebot.support.numbers import to_number

ALL = "shellies/command"


@dataclass(frozen=True, slots=True)
class _Model:
    """A product: its name in topics, its type code, and the mode it is in."""

    name: str
    code: str
    mode: str = ""
    command_topics: tuple[str, ...] = ()


_ROLLER = _Model("shellyswitch25", "SHSW-25", "roller", ("roller/0/command", "roller/0/command/pos"))
_MODELS: Mapping[str, _Model] = {
    "lamp": _Model("ShellyBulbDuo", "SHBDUO-1", command_topics=("light/0/command", "light/0/set")),
    "window": _ROLLER,
    "cover": _ROLLER,
    "contact": _Model("shellydw2", "SHDW-2"),
    "power_meter": _Model("shellyem", "SHEM"),
}


class ShellyDialect(Dialect):
    """Lamps, motors, contacts and meters with the topics that they have out of the box."""

    kinds = frozenset(_MODELS)

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return where it takes commands, and where all Shellys do."""
        base = _base(device)
        return (ALL, f"{base}/command", *(f"{base}/{level}" for level in _MODELS[device.kind].command_topics))

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return that it is online, kept, and its announcement."""
        return (OutgoingMessage(f"{_base(device)}/online", b"true", retain=True), *_announce(device))

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage:
        """Return that it is offline, kept."""
        return OutgoingMessage(f"{_base(device)}/online", b"false", retain=True)

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return its state."""
        base = _base(device)
        return tuple(
            OutgoingMessage(f"{base}/{level}", payload) for level, payload in _state(device.kind, state).items()
        )

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the meaning of a command."""
        channel = topic.removeprefix(f"{_base(device)}/")
        if channel not in _MODELS[device.kind].command_topics:
            return ()
        text = as_text(payload)
        fields = as_object(payload) if channel == "light/0/set" else {"turn": text}
        return device_orders(
            device.kind,
            is_on={"on": True, "off": False}.get(str(fields.get("turn"))),
            brightness=scaled(fields.get("brightness"), 100),
            kelvin=to_number(fields.get("temp")),
            position=scaled(text, 100) if channel.endswith("/pos") else None,
            action="" if channel.endswith("/pos") else text,
        )

    def replies(
        self, device: SimulatedDeviceInfo, state: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return its announcement or its state, where ``announce`` or ``update`` asked for it."""
        if topic not in {ALL, f"{_base(device)}/command"}:
            return ()
        return {"announce": _announce(device), "update": self.state_messages(device, state)}.get(as_text(payload), ())


def _base(device: SimulatedDeviceInfo) -> str:
    return f"shellies/{_id(device)}"


def _id(device: SimulatedDeviceInfo) -> str:
    return f"{_MODELS[device.kind].name}-{hardware_address(device).upper()}"


def _announce(device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
    model = _MODELS[device.kind]
    payload = {
        "id": _id(device),
        "model": model.code,
        "mac": hardware_address(device).upper(),
        "ip": "192.0.2.1",
        "new_fw": False,
        "fw_ver": "20230913-112003/v1.14.0-gcb84623",
        **({"mode": model.mode} if model.mode else {}),
    }
    return tuple(
        OutgoingMessage(topic, as_json(payload)) for topic in ("shellies/announce", f"{_base(device)}/announce")
    )


def _state(kind: str, state: DeviceState) -> dict[str, bytes]:
    if kind == "lamp":
        brightness = round(state.brightness * 100)
        status = {"ison": state.is_on, "brightness": brightness, "temp": round(state.kelvin)}
        return {"light/0": b"on" if state.is_on else b"off", "light/0/status": as_json(status)}
    if kind == "contact":
        return {"sensor/state": b"open" if state.text == "open" else b"close"}
    if kind == "power_meter":
        return {"emeter/0/power": number_text(state.value, 2).encode()}
    moves = {1: b"open", -1: b"close"}.get(state.way, b"stop")
    return {"roller/0": moves, "roller/0/pos": number_text(state.position * 100, 0).encode()}
