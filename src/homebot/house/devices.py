"""Simulated devices that take commands: lamps, motors, door locks, and thermostats with the room they heat."""

import math
import random
from dataclasses import dataclass, field
from typing import ClassVar

from homebot.house.simulated_device import SimulatedDevice, number, number_text

KELVIN = (1500.0, 9000.0)
"""From candle light to a blue sky."""


@dataclass(eq=False)
class SimulatedLamp(SimulatedDevice):
    """A lamp that obeys and reports at once.

    It takes ``on``, ``off``, a brightness from ``0`` to ``1``, and a colour temperature such as ``2700 K``.

    Attributes:
        brightness: Brightness while on, 0 to 1.
        kelvin: Colour temperature.
        rated_watts: Power at full brightness, above 0: a lamp without power is dark.
        rated_lux: Illuminance of its room at full brightness.
    """

    kind: ClassVar[str] = "lamp"
    by_hand = ("on", "off", "0 to 1", f"{KELVIN[0]:g} K to {KELVIN[1]:g} K")
    is_on: bool = False
    brightness: float = 1.0
    kelvin: float = 2700.0
    rated_watts: float = 9.0
    rated_lux: float = 150.0
    service_type: str = field(default="lights", kw_only=True)

    def state(self) -> str:
        """Return ``on`` or ``off``."""
        return "on" if self.is_on else "off"

    def watts(self) -> float:
        """Return watts, proportional to the brightness."""
        return self.rated_watts * self.brightness if self.is_on else 0.0

    def lux(self) -> float:
        """Return the light that it gives its room."""
        return self.rated_lux * self.brightness if self.is_on else 0.0

    def restore(self) -> str:
        """Return ``on`` or ``off``."""
        return self.state()

    def _obey(self, command: str) -> tuple[str, ...]:
        if command in {"on", "off"}:
            self.is_on = command == "on"
            return (command,)
        if command.endswith(" K"):
            kelvin = number(command.removesuffix(" K"), *KELVIN)
            if kelvin is None:
                return ()
            self.kelvin = kelvin
            return (f"{number_text(kelvin)} K",)
        brightness = number(command, 0.0, 1.0)
        if brightness is None:
            return ()
        self.is_on = brightness > 0
        self.brightness = brightness or self.brightness
        return (number_text(brightness),)


@dataclass(eq=False)
class WindowMotor(SimulatedDevice):
    """A motor that takes a while to ``open`` or ``close`` its window.

    It also takes ``stop`` and a position from ``0`` (closed) to ``1`` (open), and moves at constant speed. It reports
    ``opening`` or ``closing``, then its final state: ``open``, ``closed`` or a position.

    Attributes:
        is_open: Whether it was not closed when it last stopped.
        travel_time: Seconds from one end to the other, above 0.
    """

    kind: ClassVar[str] = "window"
    by_hand = ("open", "close", "stop", "0 to 1")
    is_open: bool = False
    travel_time: float = 3.0
    service_type: str = field(default="windows", kw_only=True)

    def __post_init__(self) -> None:
        self._start = self._target = 1.0 if self.is_open else 0.0
        self._started_at = self.now
        self._moves = False

    @property
    def position(self) -> float:
        """Position at :attr:`now`: 0 is closed, 1 is open."""
        return self.position_at(self.now)

    def position_at(self, now: float) -> float:
        """Return the position at *now*, not before :attr:`now`, if no command arrives until then."""
        if not self._moves:
            return self._target
        way = min((now - self._started_at) / self.travel_time, abs(self._target - self._start))
        return self._start + (way if self._target > self._start else -way)

    def state(self) -> str:
        """Return ``open``, ``closed`` or a position; while moving, ``opening`` or ``closing``."""
        if self._moves:
            return "opening" if self._target > self._start else "closing"
        return _position_text(self._target)

    def watts(self) -> float:
        """Return 40 W while it moves."""
        return 40.0 if self._moves else 0.0

    def restore(self) -> str:
        """Return ``open``, ``close`` or its position."""
        return {"open": "open", "closed": "close"}.get(_position_text(self.position), number_text(self.position))

    def next_event(self) -> float | None:
        """Return when it arrives."""
        return self._started_at + abs(self._target - self._start) * self.travel_time if self._moves else None

    def _obey(self, command: str) -> tuple[str, ...]:
        position = self.position
        if command == "stop":
            self._rest(position)
            return (self.state(),)
        wanted = {"open": 1.0, "close": 0.0}.get(command)
        target = number(command, 0.0, 1.0) if wanted is None else wanted
        if target is None:
            return ()
        if target == position:
            self._rest(position)
        else:
            self._start, self._target, self._started_at, self._moves = position, target, self.now, True
        return (self.state(),)

    def _on_timer(self) -> tuple[str, ...]:
        self._rest(self._target)
        return (self.state(),)

    def _rest(self, position: float) -> None:
        self._target, self._moves, self.is_open = position, False, position > 0


@dataclass(eq=False)
class CoverMotor(WindowMotor):
    """A shutter or blind: like a window motor, but slower and initially open. Its position is the light it lets in."""

    kind: ClassVar[str] = "cover"
    is_open: bool = True
    travel_time: float = 20.0
    service_type: str = field(default="covers", kw_only=True)


@dataclass(eq=False)
class SimulatedLift(SimulatedDevice):
    """A lift that takes the name of a floor, and, while it stands, ``open`` and ``close`` for its door.

    It goes nowhere before its door is closed. It reports each floor that it passes, and the states of its door.

    Attributes:
        floors: The floors from the lowest to the highest.
        travel_time: Seconds from one floor to the next, above 0.
        door_time: Seconds in which the door opens or closes, above 0.
    """

    kind: ClassVar[str] = "lift"
    floors: tuple[str, ...] = ("ground", "upper")
    travel_time: float = 8.0
    door_time: float = 3.0
    service_type: str = field(default="lifts", kw_only=True)
    door: str = field(default="closed", init=False)

    def __post_init__(self) -> None:
        self.floor = self._wanted = self.floors[0]
        self._acts_at: float | None = None

    def state(self) -> str:
        """Return the floor where it is, or which it passed last."""
        return self.floor

    def commands(self) -> tuple[str, ...]:
        """Return its floors, and the commands of its door."""
        return (*self.floors, "open", "close")

    def restore(self) -> str:
        """Return its floor."""
        return self.floor

    def next_event(self) -> float | None:
        """Return when it reaches a floor, or its door the end of its way."""
        return self._acts_at

    def _obey(self, command: str) -> tuple[str, ...]:
        travels = self.floor != self._wanted
        if command in self.floors and self.door == "closed":
            self._wanted = command
            if not travels and command != self.floor:
                self._acts_at = self.now + self.travel_time
        elif command in {"open", "close"} and not travels:
            self.door, self._acts_at = {"open": "opening", "close": "closing"}[command], self.now + self.door_time
            return (self.door,)
        return (self.state(),) if command in self.commands() else ()

    def _on_timer(self) -> tuple[str, ...]:
        self._acts_at = None
        if self.floor == self._wanted:
            self.door = {"opening": "open", "closing": "closed"}.get(self.door, self.door)
            return (self.door,)
        at, wanted = self.floors.index(self.floor), self.floors.index(self._wanted)
        self.floor = self.floors[at + (1 if wanted > at else -1)]
        self._acts_at = None if self.floor == self._wanted else self.now + self.travel_time
        return (self.floor,)


def _position_text(position: float) -> str:
    return {0.0: "closed", 1.0: "open"}.get(position, number_text(position))


@dataclass(eq=False)
class SimulatedDoorLock(SimulatedDevice):
    """A lock that takes ``lock`` and ``unlock``; reports ``locking`` or ``unlocking``, then its final state.

    A jammed lock reports ``jammed`` and keeps its position; a further command tries again.

    Attributes:
        is_locked: Whether the bolt is out.
        travel_time: Seconds for which the bolt moves.
        jams: The share of moves, 0 to 1, in which the bolt sticks.
        rng: Decides when it jams.
    """

    kind: ClassVar[str] = "lock"
    by_hand = ("lock", "unlock")
    is_locked: bool = True
    travel_time: float = 2.0
    jams: float = 0.0
    rng: random.Random = field(default_factory=lambda: random.Random(0), repr=False)  # noqa: S311  # physics, no secrets
    service_type: str = field(default="locks", kw_only=True)

    def __post_init__(self) -> None:
        self._state_text = "locked" if self.is_locked else "unlocked"
        self._arrives_at: float | None = None
        self._wants_locked = self.is_locked

    def state(self) -> str:
        """Return ``locked``, ``unlocked`` or ``jammed``; while moving, ``locking`` or ``unlocking``."""
        return self._state_text

    def restore(self) -> str:
        """Return ``lock`` or ``unlock``."""
        return "lock" if self.is_locked else "unlock"

    def next_event(self) -> float | None:
        """Return when the bolt arrives."""
        return self._arrives_at

    def _obey(self, command: str) -> tuple[str, ...]:
        if command not in {"lock", "unlock"}:
            return ()
        self._wants_locked = command == "lock"
        self._arrives_at = self.now + self.travel_time
        self._state_text = f"{command}ing"
        return (self._state_text,)

    def _on_timer(self) -> tuple[str, ...]:
        self._arrives_at = None
        if self.rng.random() < self.jams:
            self._state_text = "jammed"
        else:
            self.is_locked = self._wants_locked
            self._state_text = "locked" if self.is_locked else "unlocked"
        return (self._state_text,)


MIN_TARGET_CELSIUS, MAX_TARGET_CELSIUS = 5.0, 30.0
"""Range of targets, in degrees Celsius."""

PERIOD = 300.0
"""Seconds between readings of the thermometer; rooms are slow."""

_DEGREES = " °C"

BAND = 0.3
"""Kelvin below the target at which heating starts; it stops at as much above."""


@dataclass(eq=False)
class SimulatedThermostat(SimulatedDevice):
    """A thermostat in a room that cools towards the weather and, while heated, warms towards ``weather + gain``.

    First-order: the difference to the final temperature shrinks to 1/e within ``inertia`` seconds. It takes a target
    from ``5`` to ``30``, reports that target, and later the room's temperature whenever it has changed by 0.1 K. All
    temperatures are in degrees Celsius. It senses the temperature outside.

    Attributes:
        celsius: Temperature of the room.
        target: Setpoint of the room.
        gain: Kelvin above outside that full heating can maintain.
        inertia: Time constant in seconds.
        rated_watts: Power of the heating.
    """

    kind: ClassVar[str] = "thermostat"
    by_hand = (f"{MIN_TARGET_CELSIUS:g} to {MAX_TARGET_CELSIUS:g}",)
    senses = ("temperature", float)
    celsius: float = 20.0
    target: float = 20.0
    outside: float = 10.0
    gain: float = 30.0
    inertia: float = 20_000.0
    rated_watts: float = 1000.0
    service_type: str = field(default="thermostats", kw_only=True)

    def __post_init__(self) -> None:
        self._looks_at = self.now + PERIOD
        self._reported = self.celsius
        self.heats = False

    def state(self) -> str:
        """Return the room's temperature as text."""
        return number_text(self.celsius, 1)

    def watts(self) -> float:
        """Return its rated power while it heats."""
        return self.rated_watts if self.heats else 0.0

    def restore(self) -> str:
        """Return the target as text."""
        return number_text(self.target)

    def apply_input(self, value: float, now: float) -> tuple[str, ...]:
        """Set the outside temperature to *value* degrees Celsius."""
        reports = self.advance(now)
        self.outside = value
        return reports

    def operate_manually(self, command: str, now: float) -> tuple[str, ...]:
        """Take a target by hand, or a temperature of the room, see :meth:`sensing`."""
        if not command.endswith(_DEGREES):
            return super().operate_manually(command, now)
        reports = self.advance(now)
        self.celsius = self._reported = float(command.removesuffix(_DEGREES))
        return (*reports, self.state())

    def sensing(self, value: float) -> str:
        """Return the command for a room of *value* degrees, from which it then cools or warms."""
        return f"{number_text(value)}{_DEGREES}"

    def next_event(self) -> float | None:
        """Return when it next reads the thermometer."""
        return self._looks_at

    def _obey(self, command: str) -> tuple[str, ...]:
        target = number(command, MIN_TARGET_CELSIUS, MAX_TARGET_CELSIUS)
        if target is None:
            return ()
        self.target = target
        return (number_text(target),)

    def _on_timer(self) -> tuple[str, ...]:
        self._looks_at += PERIOD
        tends_to = self.outside + (self.gain if self.heats else 0.0)
        self.celsius = tends_to + (self.celsius - tends_to) * math.exp(-PERIOD / self.inertia)
        if abs(self.celsius - self.target) > BAND:
            self.heats = self.celsius < self.target
        if abs(self.celsius - self._reported) < 0.1:
            return ()
        self._reported = self.celsius
        return (self.state(),)
