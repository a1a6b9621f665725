"""A simulated device: a state machine driven by time and commands, and its place in a house."""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar, Final, NamedTuple

from homebot.support.numbers import to_number


class Drive(NamedTuple):
    """The room of a self-driving device, and whether it is driving."""

    room: str = ""
    drives: bool = False


_STAYS = Drive()


@dataclass(eq=False)
class SimulatedDevice(ABC):
    """A simulated device. It reads no clock: callers pass the time, in seconds, which never goes back.

    Time 0 is the midnight before the house starts.

    Attributes:
        now: The time to which it was last advanced.
        reserved_until: The time until which errands of the house wait for it.
        last_sender: The sender of its last command, in words; empty if there was none.
        senses: The property of its handle that it senses, with the type of its values; None for a device that senses
            nothing.
        by_hand: The manual commands that every device of its kind knows, see :meth:`commands`.
        stays: Whether it stays in its room.
    """

    kind: ClassVar[str]
    senses: ClassVar[tuple[str, type[bool | float]] | None] = None
    by_hand: ClassVar[tuple[str, ...]] = ()
    stays: ClassVar[bool] = True
    device_id: str
    service_type: str = field(default="", kw_only=True)
    now: float = field(default=0.0, init=False)
    reserved_until: float = field(default=0.0, init=False)
    last_sender: str = field(default="", init=False)

    @property
    def has_power(self) -> bool:
        """True if it has power at :attr:`now`, without which it neither receives nor sends."""
        return True

    @property
    def drive(self) -> Drive:
        """Its drive; constant for a device that does not drive."""
        return _STAYS

    @abstractmethod
    def state(self) -> str:
        """Return its reported state."""

    def handle_command(self, command: str, now: float) -> tuple[str, ...]:
        """Execute *command* at *now*.

        Args:
            command: A text such as ``on``, or a number as text; unknown ones are ignored.

        Returns:
            Its immediate reports, after any due earlier; later ones are returned by :meth:`advance`.
        """
        return (*self.advance(now), *self._obey(command))

    def advance(self, now: float) -> tuple[str, ...]:
        """Advance to *now*, and return the reports due until then, oldest first."""
        reports: list[str] = []
        while (at := self.next_event()) is not None and at <= now:
            self.now = max(self.now, at)
            reports += self._on_timer()
        self.now = max(self.now, now)
        return tuple(reports)

    def next_event(self) -> float | None:
        """Return when it next acts by itself, or None."""
        return None

    def apply_input(self, value: float, now: float) -> tuple[str, ...]:
        """Apply an input of the world; the device defines the meaning of *value*. Return its reports.

        Most devices ignore it.
        """
        del value
        return self.advance(now)

    def operate_manually(self, command: str, now: float) -> tuple[str, ...]:
        """Operate it by hand with *command*; return its immediate reports."""
        return self.handle_command(command, now)

    def sensing(self, value: float) -> str:
        """Return the manual command by which a test lets it sense *value*, 1 and 0 for true and false."""
        return number_text(value)

    def commands(self) -> tuple[str, ...]:
        """Return the manual commands, for people: each one, or a text for a range, such as ``0 to 1``."""
        return self.by_hand

    def knows(self, command: str) -> bool:
        """Return whether *command* is a manual command of it."""
        return any(_is_one(command, known) for known in self.commands())

    def watts(self) -> float:
        """Return the power it draws, in watts."""
        return 0.0

    def heartbeat(self) -> tuple[str, ...] | None:
        """Return the report of a heartbeat; None to repeat the last one."""
        return None

    def restore(self) -> str:
        """Return the command that restores its current state; empty for none."""
        return ""

    def _obey(self, command: str) -> tuple[str, ...]:
        """Obey at :attr:`now`; return the immediate reports."""
        del command
        return ()

    def _on_timer(self) -> tuple[str, ...]:
        """Carry out the event that :meth:`next_event` announced, which must advance."""
        return ()


DEFAULT_DIALECT: Final = "thesis"
"""The family of devices for which a house states none."""


class Placed(NamedTuple):
    """A device and its place.

    Attributes:
        door: For a contact or lock: the room on the other side of its door.
        dialect: The name of its family.
        at: Its position in metres, if known.
    """

    device: SimulatedDevice
    room: str
    door: str = ""
    dialect: str = DEFAULT_DIALECT
    at: tuple[float, float] | None = None


class ScheduledCommand(NamedTuple):
    """A command given every day by a timer.

    Attributes:
        at: Seconds since midnight.
    """

    at: float
    device_id: str
    command: str


def _is_one(command: str, known: str) -> bool:
    low, to, high = known.partition(" to ")
    if not to:
        return command == known
    (least, _, unit), (value, _, of) = low.partition(" "), command.partition(" ")
    return unit == of and number(value, float(least), float(high.removesuffix(f" {unit}"))) is not None


def number(text: str, low: float, high: float) -> float | None:
    """Return the number in *text*, or None if it is not one from *low* to *high*."""
    value = to_number(text)
    return value if value is not None and low <= value <= high else None


def number_text(value: float, digits: int = 3) -> str:
    """Return *value* as reported by devices: decimal text with at most *digits* decimals."""
    return f"{round(value, digits) + 0.0:.{digits}f}".rstrip("0").rstrip(".") if digits else f"{round(value)}"
