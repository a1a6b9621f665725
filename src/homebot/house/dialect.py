"""Families of devices: pure functions between a device of :mod:`homebot.house` and MQTT, one class per family.

A command or report is a text such as ``on`` or ``21.5``; the dialect defines the messages on the wire. Here, a device
behind a bridge publishes everything itself; only the bridge's messages about itself and all its devices come from a
separate client.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, NamedTuple, final

from homebot.errors import UsageError
from homebot.house.devices import SimulatedLamp, SimulatedLift, SimulatedThermostat, WindowMotor
from homebot.house.sensors import PowerMeter
from homebot.house.simulated_device import SimulatedDevice, number


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceState:
    """The reported state of a device; missing values keep their defaults.

    Attributes:
        text: Its last state as text, for example ``on``, ``opening`` or ``21.5``; of a ``contact``, ``lock``,
            ``motion``, ``presence``, ``robot`` and ``tag`` all that there is: ``open``, ``jammed``, ``motion``.
        is_on: Of a ``lamp``: whether it is on.
        brightness: Of a ``lamp``: brightness while on, 0 to 1.
        kelvin: Of a ``lamp``: its colour temperature.
        position: Of a ``window`` or ``cover``: 0 is closed, 1 is open.
        way: Of a ``window`` or ``cover``: 1 while it opens, -1 while it closes, 0 at rest.
        value: Of a ``lux`` or ``power_meter``: lux or watts; 0 for none.
        kilowatt_hours: Of a ``power_meter``: the energy counted.
        celsius: Of a ``thermostat``: the room's temperature.
        target: Of a ``thermostat``: its setpoint.
        heats: Of a ``thermostat``: whether it heats.
        floor: Of a ``lift``: where it is.
        door: Of a ``lift``: the state of its door.
    """

    text: str
    is_on: bool = False
    brightness: float = 1.0
    kelvin: float = 2700.0
    position: float = 0.0
    way: int = 0
    value: float = 0.0
    kilowatt_hours: float = 0.0
    celsius: float = 20.0
    target: float = 20.0
    heats: bool = False
    floor: str = ""
    door: str = ""


def state_of(device: SimulatedDevice, text: str) -> DeviceState:
    """Return the state of *device*, whose last report is *text*, perhaps a lie.

    Args:
        device: The actual device, without its faults.
        text: The reported state.
    """
    if isinstance(device, SimulatedLamp):
        return _lamp(device, text)
    if isinstance(device, WindowMotor):
        return _motor(device, text)
    if isinstance(device, SimulatedLift):
        now = DeviceState(text=text, floor=device.floor, door=device.door)
        return replace(now, floor=text) if text in device.floors else replace(now, door=text)
    if isinstance(device, SimulatedThermostat):
        return DeviceState(text=text, celsius=device.celsius, target=device.target, heats=device.heats)
    counted = device.kilowatt_hours if isinstance(device, PowerMeter) else 0.0
    return DeviceState(text=text, value=number(text, float("-inf"), float("inf")) or 0.0, kilowatt_hours=counted)


def _lamp(lamp: SimulatedLamp, text: str) -> DeviceState:
    now = DeviceState(text=text, is_on=lamp.is_on, brightness=lamp.brightness, kelvin=lamp.kelvin)
    if text in {"on", "off"}:
        return replace(now, is_on=text == "on")
    if text.endswith(" K"):
        kelvin = number(text.removesuffix(" K"), 1.0, 100_000.0)
        return now if kelvin is None else replace(now, kelvin=kelvin)
    brightness = number(text, 0.0, 1.0)
    if brightness is None:
        return now
    return replace(now, is_on=brightness > 0, brightness=brightness or now.brightness)


def _motor(motor: WindowMotor, text: str) -> DeviceState:
    now = DeviceState(text=text, position=motor.position, way=0)
    if text in {"opening", "closing"}:
        return replace(now, way=1 if text == "opening" else -1)
    if text in {"open", "closed"}:
        return replace(now, position=1.0 if text == "open" else 0.0)
    position = number(text, 0.0, 1.0)
    return now if position is None else replace(now, position=position)


@dataclass(frozen=True, slots=True)
class SimulatedDeviceInfo:
    """The identity of a simulated device.

    Attributes:
        home: First level or levels of the topics.
        commands: The manual commands that it knows, such as the floors of a lift.

    Raises:
        UsageError: The name or service type is empty, or cannot be one level of a topic.
    """

    home: str
    kind: str
    device_id: str
    service_type: str
    room: str
    commands: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for level in (self.device_id, self.service_type):
            if not level or any(character in level for character in "/+#\0"):
                raise UsageError(f"{level!r} cannot be a level of a topic, as a device's name and service type must")


class OutgoingMessage(NamedTuple):
    """A message that a device sends.

    Attributes:
        qos: Quality of service, 0 to 2.
    """

    topic: str
    payload: bytes
    retain: bool = False
    qos: int = 1


class Bridge(NamedTuple):
    """The program that publishes for all devices bound to it.

    Attributes:
        birth: Messages on each new link.
        will: The last will.
    """

    birth: tuple[OutgoingMessage, ...]
    will: OutgoingMessage


class Dialect(ABC):
    """A family of devices. Its functions never raise, for any state or payload.

    Attributes:
        announces: Whether its devices announce themselves.
    """

    announces: ClassVar[bool] = True

    @property
    @abstractmethod
    def kinds(self) -> frozenset[str]:
        """The kinds of devices in this family, as named in descriptions of houses."""

    @abstractmethod
    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return the messages that report *state* of *device*."""

    def filters(self, device: SimulatedDeviceInfo) -> tuple[str, ...]:
        """Return the topic filters to which *device* subscribes."""
        del device
        return ()

    def availability(self, device: SimulatedDeviceInfo) -> tuple[str, bytes, bytes] | None:
        """Return the topic of its availability, and the payloads for online and offline; None for none."""
        del device
        return None

    def announcement(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return the messages that announce *device*."""
        del device
        return ()

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return the first messages of *device* on each new link, before its state."""
        messages = self.availability(device)
        online = () if messages is None else (OutgoingMessage(messages[0], messages[1], retain=True),)
        return (*self.announcement(device), *online)

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage | None:
        """Return the last will of *device*."""
        messages = self.availability(device)
        return None if messages is None else OutgoingMessage(messages[0], messages[2], retain=True)

    def parse_command(self, device: SimulatedDeviceInfo, topic: str, payload: bytes) -> tuple[str, ...]:
        """Return the commands in a received message."""
        del device, topic, payload
        return ()

    def replies(
        self, device: SimulatedDeviceInfo, state: DeviceState, topic: str, payload: bytes
    ) -> tuple[OutgoingMessage, ...]:
        """Return the answers of *device* to a message, if any."""
        del device, state, topic, payload
        return ()

    def bridge(self, devices: Sequence[SimulatedDeviceInfo]) -> Bridge | None:
        """Return the bridge of *devices*, all of this family in a house, or None."""
        del devices
        return None


@final
class BridgeDialect(Dialect):
    """A bridge as a device, which publishes the bridge's messages and takes no commands."""

    kinds = frozenset()

    def __init__(self, bridge: Bridge) -> None:
        self._bridge = bridge

    def birth(self, device: SimulatedDeviceInfo) -> tuple[OutgoingMessage, ...]:
        """Return the messages of the bridge on each new link."""
        del device
        return self._bridge.birth

    def will(self, device: SimulatedDeviceInfo) -> OutgoingMessage | None:
        """Return the last will of the bridge."""
        del device
        return self._bridge.will

    def state_messages(self, device: SimulatedDeviceInfo, state: DeviceState) -> tuple[OutgoingMessage, ...]:
        """Return nothing."""
        del device, state
        return ()
