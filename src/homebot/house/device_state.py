"""State of a simulated device, as far as it reports it: the content of a message of its whole state."""

from __future__ import annotations

from dataclasses import dataclass, replace

from homebot.house.lamp import SimulatedLamp
from homebot.house.motor import WindowMotor
from homebot.house.simulated_device import SimulatedDevice, number
from homebot.house.thermostat import SimulatedThermostat

__all__ = ["DeviceState", "state_of"]


@dataclass(frozen=True, slots=True, kw_only=True)
class DeviceState:
    """The reported state of a device; what its kind does not have keeps its default.

    Attributes:
        text: Its last state as text, for example ``on``, ``opening``, ``locked`` or ``21.5``.
        is_on: Of a lamp: whether it shines.
        brightness: Of a lamp: how bright it is while on, 0 to 1.
        kelvin: Of a lamp: its colour temperature.
        position: Of a motor: 0 is closed, 1 is open.
        way: Of a motor: 1 while it opens, -1 while it closes, 0 at rest.
        value: The number that a sensor says; 0 where it says none.
        celsius: Of a thermostat: the room's temperature.
        target: Of a thermostat: what it should be.
        heats: Of a thermostat: whether it heats.
    """

    text: str
    is_on: bool = False
    brightness: float = 1.0
    kelvin: float = 2700.0
    position: float = 0.0
    way: int = 0
    value: float = 0.0
    celsius: float = 20.0
    target: float = 20.0
    heats: bool = False


def state_of(device: SimulatedDevice, text: str) -> DeviceState:
    """Return how *device* is, if the state it reported last is *text*, which may be a lie.

    Args:
        device: The device itself, under all its faults.
        text: The state that it reported.
    """
    if isinstance(device, SimulatedLamp):
        return _lamp(device, text)
    if isinstance(device, WindowMotor):
        return _motor(device, text)
    if isinstance(device, SimulatedThermostat):
        return DeviceState(text=text, celsius=device.celsius, target=device.target, heats=device.heats)
    return DeviceState(text=text, value=number(text, float("-inf"), float("inf")) or 0.0)


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
