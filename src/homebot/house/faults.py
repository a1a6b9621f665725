"""Faults of devices: wrappers of any device, which are devices themselves, so that faults combine.

A fault receives commands before the device, and reports before the world. ``device`` is the wrapped device;
:func:`unwrap` returns the innermost one, which has the real state.
"""

import math
import random
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field

from homebot.house.simulated_device import SimulatedDevice

HELD = 1000
"""Most commands, or reports, that a fault holds back; beyond that the oldest is lost and counted."""

DONE = {"open": "open", "close": "closed", "lock": "locked", "unlock": "unlocked"}
OPPOSITES = {"on": "off", "open": "closed", "motion": "clear", "locked": "unlocked"}
OPPOSITES |= {opposite: word for word, opposite in OPPOSITES.items()}


@dataclass(eq=False)
class DeviceFault(SimulatedDevice):
    """A device with a fault.

    Attributes:
        lost: Number of held commands and reports that overflowed.
    """

    device_id: str = field(init=False)
    service_type: str = field(default="", init=False)
    device: SimulatedDevice
    rng: random.Random
    lost: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.device_id, self.service_type, self.now = self.device.device_id, self.device.service_type, self.device.now
        self._held: deque[tuple[float, str]] = deque()

    @property
    def has_power(self) -> bool:
        """True if the device has power."""
        return self.device.has_power

    def state(self) -> str:
        """Return the state that the device reports."""
        return self.device.state()

    def commands(self) -> tuple[str, ...]:
        """Return the commands that the device knows."""
        return self.device.commands()

    def knows(self, command: str) -> bool:
        """Return whether the device knows *command*."""
        return self.device.knows(command)

    def watts(self) -> float:
        """Return the power that the device draws."""
        return self.device.watts()

    def restore(self) -> str:
        """Return the command that restores the device's state."""
        return self.device.restore()

    def advance(self, now: float) -> tuple[str, ...]:
        """Advance the fault and the device."""
        reports = super().advance(now)
        self.device.advance(now)  # to the same time; its due reports have been sent
        return reports

    def heartbeat(self) -> tuple[str, ...] | None:
        """Return the report of a heartbeat."""
        return self.device.heartbeat()

    def operate_manually(self, command: str, now: float) -> tuple[str, ...]:
        """Operate the device by hand, which most faults do not affect."""
        return (*self.advance(now), *self._deliver_all(self.device.operate_manually(command, now)))

    def apply_input(self, value: float, now: float) -> tuple[str, ...]:
        """Apply an input of the world to the device."""
        return (*self.advance(now), *self._deliver_all(self.device.apply_input(value, now)))

    def next_event(self) -> float | None:
        """Return when the device or the fault next acts by itself."""
        own = self._held[0][0] if self._held else None
        inner = self.device.next_event()
        return inner if own is None else own if inner is None else min(own, inner)

    def _obey(self, command: str) -> tuple[str, ...]:
        return self._pass(command)

    def _on_timer(self) -> tuple[str, ...]:
        reports = self._deliver_all(self.device.advance(self.now))
        while self._held and self._held[0][0] <= self.now:
            reports += self._release(self._held.popleft()[1])
        return reports

    def _pass(self, command: str) -> tuple[str, ...]:
        """Pass the command to the device."""
        return self._deliver_all(self.device.handle_command(command, self.now))

    def _deliver_all(self, reports: Iterable[str]) -> tuple[str, ...]:
        return tuple(report_text for report in reports for report_text in self._deliver(report))

    def _deliver(self, report: str) -> tuple[str, ...]:
        """Return the reports that reach the world for *report*."""
        return (report,)

    def _release(self, held: str) -> tuple[str, ...]:
        """Return the reports for one that was held back."""
        return (held,)

    def _hold(self, at: float, held: str) -> None:
        """Hold back *held* until *at*, which is never before an earlier entry."""
        if len(self._held) == HELD:
            self._held.popleft()
            self.lost += 1
        self._held.append((at, held))


@dataclass(eq=False)
class Lossy(DeviceFault):
    """Loses a share (0 to 1) of its commands and reports."""

    share: float = field(default=0.2, kw_only=True)

    def _obey(self, command: str) -> tuple[str, ...]:
        return () if self.rng.random() < self.share else self._pass(command)

    def _deliver(self, report: str) -> tuple[str, ...]:
        return () if self.rng.random() < self.share else (report,)

    def heartbeat(self) -> tuple[str, ...] | None:
        """Return its actual state, not the last report."""
        return (self.state(),)


@dataclass(eq=False)
class Slow(DeviceFault):
    """Obeys after a delay in seconds, each time up to half as long again."""

    delay: float = field(default=5.0, kw_only=True)

    def _obey(self, command: str) -> tuple[str, ...]:
        at = self.now + self.delay * self.rng.uniform(1.0, 1.5)
        self._hold(max(at, self._held[-1][0]) if self._held else at, command)  # in order of arrival
        return ()

    def _release(self, held: str) -> tuple[str, ...]:
        return self._pass(held)


@dataclass(eq=False)
class Deaf(DeviceFault):
    """Receives no commands, but reports its state."""

    def _obey(self, command: str) -> tuple[str, ...]:
        del command
        return ()


@dataclass(eq=False)
class Liar(DeviceFault):
    """From a time on (seconds since the first midnight), reports commands as done without doing anything."""

    since: float = field(default=0.0, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._lie: str | None = None

    def state(self) -> str:
        """Return the last lie, or the actual state without one."""
        return self.device.state() if self._lie is None else self._lie

    def operate_manually(self, command: str, now: float) -> tuple[str, ...]:
        """Obey hands, and report the real state again."""
        self._lie = None
        return super().operate_manually(command, now)

    def _obey(self, command: str) -> tuple[str, ...]:
        if self.now < self.since:
            return self._pass(command)
        self._lie = DONE.get(command, command)
        return (self._lie,)


@dataclass(eq=False)
class EchoingBridge(DeviceFault):
    """Reports commands at once and passes them on; the device's own reports follow."""

    def _obey(self, command: str) -> tuple[str, ...]:
        return (DONE.get(command, command), *self._pass(command))


@dataclass(eq=False)
class Stuck(DeviceFault):
    """Keeps its state: tries for some seconds, then reports the old state; sensors notice no change."""

    after: float = field(default=2.0, kw_only=True)

    def apply_input(self, value: float, now: float) -> tuple[str, ...]:
        """Ignore the input."""
        del value
        return self.advance(now)

    def operate_manually(self, command: str, now: float) -> tuple[str, ...]:
        """Ignore the hand."""
        del command
        return self.advance(now)

    def _obey(self, command: str) -> tuple[str, ...]:
        del command
        if not self._held:  # a command in the meantime gets the same answer
            self._hold(self.now + self.after, "")
        return ()

    def _release(self, held: str) -> tuple[str, ...]:
        del held
        return (self.device.state(),)


@dataclass(eq=False)
class Reverter(DeviceFault):
    """Obeys, and reverts after some seconds unless there is a later command."""

    after: float = field(default=60.0, kw_only=True)

    def _obey(self, command: str) -> tuple[str, ...]:
        before = self.device.restore()
        reports = self._pass(command)
        if reports and before:
            self._held.clear()
            self._hold(self.now + self.after, before)
        return reports

    def _release(self, held: str) -> tuple[str, ...]:
        return self._pass(held)


@dataclass(eq=False)
class Chatterbox(DeviceFault):
    """Repeats every report a number of times, at intervals in seconds."""

    times: int = field(default=50, kw_only=True)
    every: float = field(default=0.1, kw_only=True)

    def _deliver(self, report: str) -> tuple[str, ...]:
        begins = max(self.now, self._held[-1][0]) if self._held else self.now
        for number in range(1, self.times):
            self._hold(begins + number * self.every, report)
        return (report,)


@dataclass(eq=False)
class Flapper(DeviceFault):
    """Reports the opposite, on average every so many seconds, and corrects it 0.2 s later."""

    every: float = field(default=3600.0, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        self._hold(self.now + self.rng.expovariate(1 / self.every), "flap")

    def _release(self, held: str) -> tuple[str, ...]:
        word = self.device.state()
        if held == "flap":
            self._hold(self.now + 0.2, "back")
            return (OPPOSITES.get(word, "0"),)
        self._hold(self.now + self.rng.expovariate(1 / self.every), "flap")
        return (word,)


@dataclass(eq=False)
class Late(DeviceFault):
    """Delays every report by some seconds; a heartbeat repeats the last one."""

    delay: float = field(default=30.0, kw_only=True)

    def _deliver(self, report: str) -> tuple[str, ...]:
        self._hold(self.now + self.delay, report)
        return ()


@dataclass(eq=False)
class Silent(DeviceFault):
    """From a time on (seconds since the first midnight), reports nothing, not even heartbeats; it keeps its link."""

    since: float = field(default=0.0, kw_only=True)

    def heartbeat(self) -> tuple[str, ...] | None:
        """Return nothing once it is silent."""
        return () if self.now >= self.since else self.device.heartbeat()

    def _deliver(self, report: str) -> tuple[str, ...]:
        return () if self.now >= self.since else (report,)


@dataclass(eq=False)
class Unplugged(DeviceFault):
    """Without power between two times (seconds since the first midnight)."""

    since: float = field(default=0.0, kw_only=True)
    until: float = field(default=math.inf, kw_only=True)

    def __post_init__(self) -> None:
        super().__post_init__()
        times = (self.since, self.until) if self.since < self.until else ()
        self._changes = [at for at in times if self.device.now < at < math.inf]
        self._missed: float | None = None

    @property
    def has_power(self) -> bool:
        """True if it has power at :attr:`now`."""
        return not self.since <= self.now < self.until and self.device.has_power

    def watts(self) -> float:
        """Return 0 without power."""
        return self.device.watts() if self.has_power else 0.0

    def operate_manually(self, command: str, now: float) -> tuple[str, ...]:
        """Do nothing without power."""
        reports = self.advance(now)
        return reports + (super().operate_manually(command, now) if self.has_power else ())

    def apply_input(self, value: float, now: float) -> tuple[str, ...]:
        """Ignore the input without power; a lasting one is applied when power returns."""
        reports = self.advance(now)
        if not self.has_power:
            self._missed = value
            return reports
        return reports + self._deliver_all(self.device.apply_input(value, now))

    def next_event(self) -> float | None:
        """Return the next time at which anything happens, including loss and return of power."""
        inner = super().next_event()
        own = self._changes[0] if self._changes else None
        return inner if own is None else own if inner is None else min(own, inner)

    def _obey(self, command: str) -> tuple[str, ...]:
        return self._pass(command) if self.has_power else ()

    def _on_timer(self) -> tuple[str, ...]:
        reports = super()._on_timer()
        if not self._changes or self._changes[0] > self.now:
            return reports
        if self._changes.pop(0) != self.until:
            return reports
        if self._missed is not None:
            self.device.apply_input(self._missed, self.now)
            self._missed = None
        return (self.state(),)  # its only report when it starts

    def _deliver(self, report: str) -> tuple[str, ...]:
        return (report,) if self.has_power else ()


def unwrap(device: SimulatedDevice) -> SimulatedDevice:
    """Return the device without its faults."""
    while isinstance(device, DeviceFault):
        device = device.device
    return device
