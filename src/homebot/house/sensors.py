"""Sensors: they take no command and report inputs from the world."""

from dataclasses import dataclass, field
from typing import ClassVar, Final

from homebot.house.simulated_device import SimulatedDevice, number_text
from homebot.support.numbers import to_number

_MEASURE: Final = "measure"
_STAYS: Final = "motion stays"
_LEFT: Final = "motion left"


@dataclass(eq=False)
class SimulatedContactSensor(SimulatedDevice):
    """A contact on a door or window: senses 1 for open and 0 for closed."""

    kind: ClassVar[str] = "contact"
    by_hand = ("open", "close")  # the world handles them, because the door or window stays so
    senses = ("is_open", bool)
    is_open: bool = False
    service_type: str = field(default="contacts", kw_only=True)

    def state(self) -> str:
        """Return ``open`` or ``closed``."""
        return "open" if self.is_open else "closed"

    def apply_input(self, value: float, now: float) -> tuple[str, ...]:
        """Report a change."""
        self.advance(now)
        if (value > 0) == self.is_open:
            return ()
        self.is_open = value > 0
        return (self.state(),)

    def sensing(self, value: float) -> str:
        """Return ``open`` or ``close``."""
        return "open" if value else "close"


@dataclass(eq=False)
class MotionSensor(SimulatedDevice):
    """A motion sensor: senses the number of moving people; reports ``motion`` at once, ``clear`` after a while.

    ``motion`` by hand is a person walking past.

    Attributes:
        hold: Seconds without motion after which it is ``clear``.
    """

    kind: ClassVar[str] = "motion"
    by_hand = ("motion",)
    senses = ("occupied", bool)
    hold: float = 60.0
    service_type: str = field(default="motions", kw_only=True)

    def __post_init__(self) -> None:
        self._sees_motion = False
        self._is_held = False
        self._clear_at: float | None = None

    def state(self) -> str:
        """Return ``motion`` or ``clear``."""
        return "motion" if self._sees_motion else "clear"

    def apply_input(self, value: float, now: float) -> tuple[str, ...]:
        """Report the beginning of motion."""
        reports = self.advance(now)
        if value > 0:
            self._clear_at = None
            reports += () if self._sees_motion else ("motion",)
            self._sees_motion = True
        elif self._sees_motion and self._clear_at is None and not self._is_held:
            self._clear_at = self.now + self.hold
        return reports

    def operate_manually(self, command: str, now: float) -> tuple[str, ...]:
        """Simulate a person walking past for ``motion``; see :meth:`sensing` for one staying or leaving."""
        reports = self.advance(now)
        if command in {_STAYS, _LEFT}:
            self._is_held = command == _STAYS
            reports += self.apply_input(float(self._is_held), now)
            return reports if self._is_held or not self._sees_motion else (*reports, *self._on_timer())
        if command == "motion" and (not self._sees_motion or self._clear_at is not None):
            reports += self.apply_input(1.0, now) + self.apply_input(0.0, now)
        return reports

    def sensing(self, value: float) -> str:
        """Return the command for a person in front of it, or gone."""
        return _STAYS if value else _LEFT

    def next_event(self) -> float | None:
        """Return when it is clear."""
        return self._clear_at

    def _on_timer(self) -> tuple[str, ...]:
        self._clear_at, self._sees_motion = None, False
        return ("clear",)


@dataclass(eq=False)
class PresenceSensor(MotionSensor):
    """A radar: it senses all people in its room, also sitting or sleeping ones."""

    kind: ClassVar[str] = "presence"
    hold: float = 15.0


@dataclass(eq=False)
class _MeasuringSensor(SimulatedDevice):
    """A sensor of a number; a manual number replaces its measurements until a manual ``measure``."""

    by_hand = ("a number", _MEASURE)

    def __post_init__(self) -> None:
        self._measured = 0.0
        self._by_hand: float | None = None

    def apply_input(self, value: float, now: float) -> tuple[str, ...]:
        """Report the new value if it differs enough."""
        self.advance(now)
        self._measured = value
        return self._report(value if self._by_hand is None else self._by_hand)

    def operate_manually(self, command: str, now: float) -> tuple[str, ...]:
        """Measure the number *command*, or with ``measure`` the world again."""
        self.advance(now)
        if self.knows(command):
            self._by_hand = to_number(command)
        return self._report(self._measured if self._by_hand is None else self._by_hand)

    def knows(self, command: str) -> bool:
        """Return whether *command* is a manual command."""
        return command == _MEASURE or to_number(command) is not None

    def _report(self, value: float) -> tuple[str, ...]:
        """Return the report of *value*; nothing if it is close to the last one."""
        raise NotImplementedError


@dataclass(eq=False)
class LuxSensor(_MeasuringSensor):
    """A light sensor: senses lux, and reports large enough changes.

    Attributes:
        lux: The last report.
        share: The least change for a report, as a share of the last value; at least 1 lux.
    """

    kind: ClassVar[str] = "lux"
    senses = ("lux", float)
    lux: float = 0.0
    share: float = 0.2
    service_type: str = field(default="light_levels", kw_only=True)

    def state(self) -> str:
        """Return lux as text."""
        return number_text(self.lux, 1)

    def _report(self, value: float) -> tuple[str, ...]:
        if abs(value - self.lux) < max(1.0, self.share * self.lux):
            return ()
        self.lux = value
        return (self.state(),)


@dataclass(eq=False)
class PowerMeter(_MeasuringSensor):
    """A power meter: senses the watts of the whole house, or of one device like a metering plug.

    Attributes:
        total: The last report, in watts.
        kilowatt_hours: The energy counted since the start.
        step: The least change for a report, in watts.
        of: The name of the measured device; empty for the whole house.
    """

    kind: ClassVar[str] = "power_meter"
    senses = ("watts", float)
    total: float = 0.0
    step: float = 1.0
    of: str = ""
    kilowatt_hours: float = field(default=0.0, kw_only=True)
    service_type: str = field(default="power_meters", kw_only=True)

    def advance(self, now: float) -> tuple[str, ...]:
        """Count the energy until *now*."""
        self.kilowatt_hours += self.total * max(0.0, now - self.now) / 3.6e6
        return super().advance(now)

    def heartbeat(self) -> tuple[str, ...]:
        """Return the last power again, as its message also has the energy."""
        return (self.state(),)

    def state(self) -> str:
        """Return watts as text."""
        return number_text(self.total, 1)

    def _report(self, value: float) -> tuple[str, ...]:
        if abs(value - self.total) < self.step:
            return ()
        self.total = value
        return (self.state(),)
