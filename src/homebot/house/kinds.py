"""The kinds of devices and faults by name, each with its settings.

The defaults of settings are those of the device or fault.
"""

import random
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Final

from pydantic import BaseModel, ConfigDict, Field, create_model

from homebot.house import faults
from homebot.house.devices import (
    CoverMotor,
    SimulatedDoorLock,
    SimulatedLamp,
    SimulatedLift,
    SimulatedThermostat,
    WindowMotor,
)
from homebot.house.robot import Robot
from homebot.house.rooms import Rooms
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, PresenceSensor, SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice
from homebot.house.tag import SimulatedTag
from homebot.units import DURATION, Seconds

Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Moment = Annotated[Seconds, Field(ge=0.1)]
"""Seconds, above 0: an immediate answer would stop virtual time."""
_Since = Annotated[float, DURATION, Field(ge=0.0, allow_inf_nan=False)]
_Text = Annotated[str, Field(min_length=1, max_length=200)]
_Floors = Annotated[tuple[_Text, ...], Field(min_length=2, max_length=100)]
_Times = Annotated[int, Field(ge=1, le=1000)]
Celsius = Annotated[float, Field(ge=-60.0, le=60.0)]


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The surroundings of a new device."""

    name: str
    room: str
    rooms: Rooms
    rng: random.Random


class KindSettings(BaseModel):
    """The settings of a kind of device."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    makes: ClassVar[type[SimulatedDevice]]

    def build(self, at: Surroundings) -> SimulatedDevice:
        """Return the device."""
        surroundings: dict[type[SimulatedDevice], dict[str, Any]] = {
            SimulatedDoorLock: {"rng": at.rng},
            Robot: {"rooms": at.rooms, "room": at.room},
        }
        return self.makes(at.name, **surroundings.get(self.makes, {}), **self.model_dump(exclude_unset=True))


class FaultSettings(BaseModel):
    """The settings of a fault."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    makes: ClassVar[type[faults.DeviceFault]]

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        """Return *device* with the fault."""
        return self.makes(device, rng, **self.model_dump(exclude_unset=True))


def _kind(makes: type[SimulatedDevice], **settings: Any) -> type[KindSettings]:
    model = create_model(makes.__name__, __base__=KindSettings, **_optional(settings))
    model.makes = makes
    return model


def _fault(makes: type[faults.DeviceFault], **settings: Any) -> type[FaultSettings]:
    model = create_model(makes.__name__, __base__=FaultSettings, **_optional(settings))
    model.makes = makes
    return model


def _optional(settings: Mapping[str, Any]) -> dict[str, Any]:
    return {name: (kind | None, None) for name, kind in settings.items()}


KINDS: Final[dict[str, type[KindSettings]]] = {
    "lamp": _kind(
        SimulatedLamp,
        is_on=bool,
        brightness=Fraction,
        kelvin=Positive,
        rated_watts=Positive,
        rated_lux=NotNegative,
    ),
    "window": _kind(WindowMotor, is_open=bool, travel_time=Seconds),
    "cover": _kind(CoverMotor, is_open=bool, travel_time=Seconds),
    "lock": _kind(SimulatedDoorLock, is_locked=bool, travel_time=Seconds, jams=Fraction),
    "lift": _kind(SimulatedLift, floors=_Floors, travel_time=Moment, door_time=Moment),
    "contact": _kind(SimulatedContactSensor),
    "motion": _kind(MotionSensor, hold=_Since),
    "presence": _kind(PresenceSensor, hold=_Since),
    "lux": _kind(LuxSensor, share=Fraction),
    "power_meter": _kind(PowerMeter, step=Positive, of=str),
    "thermostat": _kind(
        SimulatedThermostat,
        celsius=Celsius,
        target=Celsius,
        gain=NotNegative,
        inertia=Seconds,
        rated_watts=NotNegative,
    ),
    "robot": _kind(Robot, speed=Positive),
    "tag": _kind(SimulatedTag, text=_Text, hold=Moment, every=_Since),
}
"""Kinds of devices, with their settings."""

FAULTS: Final[dict[str, type[FaultSettings]]] = {
    "lossy": _fault(faults.Lossy, share=Fraction),
    "slow": _fault(faults.Slow, delay=_Since),
    "deaf": _fault(faults.Deaf),
    "liar": _fault(faults.Liar, since=_Since),
    "echoing_bridge": _fault(faults.EchoingBridge),
    "stuck": _fault(faults.Stuck, after=Moment),
    "reverter": _fault(faults.Reverter, after=Moment),
    "chatterbox": _fault(faults.Chatterbox, times=_Times, every=Seconds),
    "flapper": _fault(faults.Flapper, every=Moment),
    "late": _fault(faults.Late, delay=Moment),
    "silent": _fault(faults.Silent, since=_Since),
    "unplugged": _fault(faults.Unplugged, since=_Since, until=Seconds),
}
"""Kinds of faults, with their settings."""
