"""The kinds of devices and faults by the names that describe them, each with the settings it takes.

A setting that is left out has the default of the device or fault, which is written there alone.
"""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field

from homebot.house import faults
from homebot.house.devices import CoverMotor, SimulatedDoorLock, SimulatedLamp, SimulatedThermostat, WindowMotor
from homebot.house.robot import Robot
from homebot.house.rooms import Rooms
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice
from homebot.house.tag import SimulatedTag
from homebot.units import DURATION, Seconds

__all__ = ["FAULTS", "KINDS", "FaultSettings", "KindSettings", "Surroundings"]

Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Moment = Annotated[Seconds, Field(ge=0.1)]
"""Seconds, above 0: an immediate answer would stop virtual time."""
_Since = Annotated[float, DURATION, Field(ge=0.0, allow_inf_nan=False)]
Celsius = Annotated[float, Field(ge=-60.0, le=60.0)]


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The surroundings that a device is made in."""

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
        return self.makes(at.name, **self._place(at), **self.model_dump(exclude_unset=True))

    def _place(self, at: Surroundings) -> dict[str, Any]:
        """Return the surroundings for a device of this kind."""
        del at
        return {}


class FaultSettings(BaseModel):
    """The settings of a fault."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    makes: ClassVar[type[faults.DeviceFault]]

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        """Return *device* with the fault."""
        return self.makes(device, rng, **self.model_dump(exclude_unset=True))


class _LampKind(KindSettings):
    makes = SimulatedLamp

    is_on: bool | None = None
    brightness: Fraction | None = None
    kelvin: Positive | None = None
    rated_watts: Positive | None = None
    rated_lux: NotNegative | None = None


class _Window(KindSettings):
    makes = WindowMotor

    is_open: bool | None = None
    travel_time: Seconds | None = None


class _Cover(_Window):
    makes = CoverMotor


class _Lock(KindSettings):
    makes = SimulatedDoorLock

    is_locked: bool | None = None
    travel_time: Seconds | None = None
    jams: Fraction | None = None

    def _place(self, at: Surroundings) -> dict[str, Any]:
        return {"rng": at.rng}


class _Contact(KindSettings):
    makes = SimulatedContactSensor


class _Motion(KindSettings):
    makes = MotionSensor

    hold: _Since | None = None


class _Lux(KindSettings):
    makes = LuxSensor

    share: Fraction | None = None


class _Meter(KindSettings):
    makes = PowerMeter

    step: Positive | None = None
    of: str | None = None


class _Thermostat(KindSettings):
    makes = SimulatedThermostat

    celsius: Celsius | None = None
    target: Celsius | None = None
    gain: NotNegative | None = None
    inertia: Seconds | None = None
    rated_watts: NotNegative | None = None


class _Tag(KindSettings):
    makes = SimulatedTag

    text: Annotated[str, Field(min_length=1, max_length=200)] | None = None
    hold: Moment | None = None
    every: _Since | None = None


class _Robot(KindSettings):
    makes = Robot

    speed: Positive | None = None

    def _place(self, at: Surroundings) -> dict[str, Any]:
        return {"rooms": at.rooms, "room": at.room}


class _Lossy(FaultSettings):
    makes = faults.Lossy

    share: Fraction | None = None


class _Slow(FaultSettings):
    makes = faults.Slow

    delay: _Since | None = None


class _Deaf(FaultSettings):
    makes = faults.Deaf


class _Liar(FaultSettings):
    makes = faults.Liar

    since: _Since | None = None


class _EchoingBridge(FaultSettings):
    makes = faults.EchoingBridge


class _Stuck(FaultSettings):
    makes = faults.Stuck

    after: Moment | None = None


class _Reverter(FaultSettings):
    makes = faults.Reverter

    after: Moment | None = None


class _Chatterbox(FaultSettings):
    makes = faults.Chatterbox

    times: Annotated[int, Field(ge=1, le=1000)] | None = None
    every: Seconds | None = None


class _Flapper(FaultSettings):
    makes = faults.Flapper

    every: Moment | None = None


class _Late(FaultSettings):
    makes = faults.Late

    delay: Moment | None = None


class _Silent(FaultSettings):
    makes = faults.Silent

    since: _Since | None = None


class _Unplugged(FaultSettings):
    makes = faults.Unplugged

    since: _Since | None = None
    until: Seconds | None = None


KINDS: dict[str, type[KindSettings]] = {
    "lamp": _LampKind,
    "window": _Window,
    "cover": _Cover,
    "lock": _Lock,
    "contact": _Contact,
    "motion": _Motion,
    "lux": _Lux,
    "power_meter": _Meter,
    "thermostat": _Thermostat,
    "robot": _Robot,
    "tag": _Tag,
}
"""Kinds of devices."""

FAULTS: dict[str, type[FaultSettings]] = {
    "lossy": _Lossy,
    "slow": _Slow,
    "deaf": _Deaf,
    "liar": _Liar,
    "echoing_bridge": _EchoingBridge,
    "stuck": _Stuck,
    "reverter": _Reverter,
    "chatterbox": _Chatterbox,
    "flapper": _Flapper,
    "late": _Late,
    "silent": _Silent,
    "unplugged": _Unplugged,
}
"""Kinds of faults."""
