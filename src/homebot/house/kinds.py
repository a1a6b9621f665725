"""The kinds of devices and faults by the names that describe them, each with the settings it takes.

A setting that is left out has the default of the device or fault, which is written there alone.
"""

from __future__ import annotations

import random
from abc import abstractmethod
from dataclasses import dataclass
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from homebot.house import faults
from homebot.house.lamp import SimulatedLamp
from homebot.house.lock import SimulatedDoorLock
from homebot.house.motor import CoverMotor, WindowMotor
from homebot.house.robot import Robot
from homebot.house.rooms import Rooms
from homebot.house.sensors import LuxSensor, MotionSensor, PowerMeter, SimulatedContactSensor
from homebot.house.simulated_device import SimulatedDevice
from homebot.house.thermostat import SimulatedThermostat

__all__ = ["FAULTS", "KINDS", "FaultSettings", "KindSettings", "Surroundings"]

Fraction = Annotated[float, Field(ge=0.0, le=1.0)]
Positive = Annotated[float, Field(gt=0.0, allow_inf_nan=False)]
NotNegative = Annotated[float, Field(ge=0.0, allow_inf_nan=False)]
Moment = Annotated[float, Field(ge=0.1, allow_inf_nan=False)]
"""Seconds, and not none: what answers at once never lets time pass."""
Celsius = Annotated[float, Field(ge=-60.0, le=60.0)]


@dataclass(frozen=True, slots=True)
class Surroundings:
    """The surroundings that a device is made in.

    Attributes:
        name: Its own name.
        room: Where it is.
        rooms: The whole plan.
        rng: Its dice.
    """

    name: str
    room: str
    rooms: Rooms
    rng: random.Random


class KindSettings(BaseModel):
    """The settings of a kind of device."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @abstractmethod
    def build(self, at: Surroundings) -> SimulatedDevice:
        """Return the device."""


class FaultSettings(BaseModel):
    """The settings of a fault."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    @abstractmethod
    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        """Return *device* with the fault."""


class _LampKind(KindSettings):
    is_on: bool | None = None
    brightness: Fraction | None = None
    kelvin: Positive | None = None
    rated_watts: Positive | None = None
    rated_lux: NotNegative | None = None

    def build(self, at: Surroundings) -> SimulatedDevice:
        return SimulatedLamp(at.name, **self.model_dump(exclude_unset=True))


class _Window(KindSettings):
    is_open: bool | None = None
    travel_time: Positive | None = None

    def build(self, at: Surroundings) -> SimulatedDevice:
        return WindowMotor(at.name, **self.model_dump(exclude_unset=True))


class _Cover(_Window):
    def build(self, at: Surroundings) -> SimulatedDevice:
        return CoverMotor(at.name, **self.model_dump(exclude_unset=True))


class _Lock(KindSettings):
    is_locked: bool | None = None
    travel_time: Positive | None = None
    jams: Fraction | None = None

    def build(self, at: Surroundings) -> SimulatedDevice:
        return SimulatedDoorLock(at.name, rng=at.rng, **self.model_dump(exclude_unset=True))


class _Contact(KindSettings):
    def build(self, at: Surroundings) -> SimulatedDevice:
        return SimulatedContactSensor(at.name)


class _Motion(KindSettings):
    hold: NotNegative | None = None

    def build(self, at: Surroundings) -> SimulatedDevice:
        return MotionSensor(at.name, **self.model_dump(exclude_unset=True))


class _Lux(KindSettings):
    share: Fraction | None = None

    def build(self, at: Surroundings) -> SimulatedDevice:
        return LuxSensor(at.name, **self.model_dump(exclude_unset=True))


class _Meter(KindSettings):
    step: Positive | None = None

    def build(self, at: Surroundings) -> SimulatedDevice:
        return PowerMeter(at.name, **self.model_dump(exclude_unset=True))


class _Thermostat(KindSettings):
    celsius: Celsius | None = None
    target: Celsius | None = None
    gain: NotNegative | None = None
    inertia: Positive | None = None
    rated_watts: NotNegative | None = None

    def build(self, at: Surroundings) -> SimulatedDevice:
        return SimulatedThermostat(at.name, **self.model_dump(exclude_unset=True))


class _Robot(KindSettings):
    speed: Positive | None = None

    def build(self, at: Surroundings) -> SimulatedDevice:
        return Robot(at.name, at.rooms, at.room, **self.model_dump(exclude_unset=True))


class _Lossy(FaultSettings):
    share: Fraction | None = None

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Lossy(device, rng, **self.model_dump(exclude_unset=True))


class _Slow(FaultSettings):
    delay: NotNegative | None = None

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Slow(device, rng, **self.model_dump(exclude_unset=True))


class _Deaf(FaultSettings):
    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Deaf(device, rng)


class _Liar(FaultSettings):
    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Liar(device, rng)


class _Stuck(FaultSettings):
    after: Moment | None = None

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Stuck(device, rng, **self.model_dump(exclude_unset=True))


class _Reverter(FaultSettings):
    after: Moment | None = None

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Reverter(device, rng, **self.model_dump(exclude_unset=True))


class _Chatterbox(FaultSettings):
    times: Annotated[int, Field(ge=1, le=1000)] | None = None
    every: Positive | None = None

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Chatterbox(device, rng, **self.model_dump(exclude_unset=True))


class _Flapper(FaultSettings):
    every: Moment | None = None

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Flapper(device, rng, **self.model_dump(exclude_unset=True))


class _Unplugged(FaultSettings):
    since: NotNegative | None = None
    until: Positive | None = None

    def apply(self, device: SimulatedDevice, rng: random.Random) -> SimulatedDevice:
        return faults.Unplugged(device, rng, **self.model_dump(exclude_unset=True))


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
}
"""Kinds of devices."""

FAULTS: dict[str, type[FaultSettings]] = {
    "lossy": _Lossy,
    "slow": _Slow,
    "deaf": _Deaf,
    "liar": _Liar,
    "stuck": _Stuck,
    "reverter": _Reverter,
    "chatterbox": _Chatterbox,
    "flapper": _Flapper,
    "unplugged": _Unplugged,
}
"""Kinds of faults."""
