"""The story of a house: actions of apps with their causes, refusals, contradictions and losses, a line each. Pure."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Final, NamedTuple, final

from homebot.devices.outcomes import cause_text
from homebot.devices.wording.journal_words import issuer_text, name_text, settings_text, trigger_text
from homebot.devices.wording.time_format import to_seconds
from homebot.devices.wording.values import plain_value
from homebot.support.bounded_map import BoundedMap
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device, DeviceChange, StateChange
    from homebot.devices.journal_messages import JournalEntry

DARK: Final = 50.0
"""Lux below which a room is dark, as for the app `follow_me`."""

_MAX_LINES: Final = 50
_MAX_COMMANDS: Final = 500
_ONE_MOMENT: Final = 1.0
"""Seconds within which the same event of two devices is one line."""

_TOLD: Final = frozenset({"stale", "returned", "removed"})
_CHANGED: Final = "·"
_MOVED: Final = "→"
_REPLACED: Final = frozenset({_CHANGED, _MOVED})
"""Signs of lines that are replaced by a later one about the same device."""

_OPPOSITE: Final = {"on": "off", "off": "on"}


class StoryLine(NamedTuple):
    """One line.

    Attributes:
        sign: One character for its kind, in the rich *style*.
        words: The rest of a sentence about the device.
        at: The time, in seconds.
        time: The time for people.
        key: Equal for lines that say the same about different devices.
    """

    sign: str
    devices: tuple[str, ...]
    words: str
    style: str
    at: float
    time: str
    key: str

    @property
    def text(self) -> str:
        """The line in words."""
        return f"{', '.join(self.devices)} {self.words}"


@final
class Story:
    """The newest lines, only from messages on the graph.

    Args:
        names: The names of devices, by id; may grow.
        time: Returns the time for people.
    """

    def __init__(self, names: Mapping[str, str], time: Callable[[], str]) -> None:
        self.lines: deque[StoryLine] = deque(maxlen=_MAX_LINES)
        self._names = names
        self._time = time
        self._commands: BoundedMap[str, JournalEntry] = BoundedMap(_MAX_COMMANDS)
        self._is_dark: dict[str, bool] = {}
        self._robots: dict[str, str] = {}

    def add_entry(self, entry: JournalEntry) -> None:
        """Add a line for the outcome of a command, or for a change that no command explains."""
        match entry.kind:
            case "requested":
                self._commands[entry.command] = entry
            case "outcome" | "reverted":
                self._add_outcome(entry)
            case "changed":
                self._add(entry, _CHANGED, f"{settings_text(entry.settings)}, {cause_text(entry.cause)}", "dim")

    def add_change(self, change: DeviceChange, at: float) -> None:
        """Add a line for a device that disappeared or returned."""
        if change.kind in _TOLD:
            device = change.device
            is_back = change.kind == "returned"
            words = f"is back: {change.why}" if is_back else f"is gone: {change.why}"
            style = "green" if is_back else "red"
            self._append("✓" if is_back else "✗", device.name or device.id, words, style, at)

    def add_values(self, change: StateChange, device: Device) -> None:
        """Add a line for a robot that departs or arrives, and for a room that gets dark or light."""
        at = to_seconds(change.told_at)
        for reading in change.readings:
            value = plain_value(reading.value)
            if reading.capability == "illuminance" and isinstance(value, float):
                self._add_light(device, value, at)
            elif device.service_type == "robots" and isinstance(value, str):
                self._add_move(device, value, at)

    def _add_light(self, device: Device, lux: float, at: float) -> None:
        is_dark = lux < DARK
        if self._is_dark.setdefault(device.id, is_dark) == is_dark:
            return
        self._is_dark[device.id] = is_dark
        sign, word, style = ("☾", "dark", "blue") if is_dark else ("☀", "light", "yellow")
        words = f"measures {lux:.0f} lx: {device.area} gets {word}"
        self._append(sign, device.name or device.id, words, style, at)

    def _add_move(self, robot: Device, where: str, at: float) -> None:
        if self._robots.get(robot.id) == where:
            return
        self._robots[robot.id] = where
        words = "drives" if where == "moving" else f"is in the {printable(where, 40)}"
        self._append(_MOVED, robot.name or robot.id, words, "cyan", at)

    def _add_outcome(self, entry: JournalEntry) -> None:
        result, asked = entry.results[0], self._commands.pop(entry.command, None)
        if asked is None or result.outcome in {"already_so", "superseded"}:
            return
        wanted = settings_text(asked.settings)
        match result.outcome:
            case "confirmed":
                seen = f", seen by {printable(result.witness, 40)}" if result.witness else ""
                reason = trigger_text(asked.trigger, self._names).replace(" reported ", " ")
                cause = f"{issuer_text(asked.issuer)}{': ' if reason else ''}{reason}"
                words = f"{wanted} in {result.latency * 1000:.0f} ms{seen} · {cause}"
                self._add(entry, "✓", words, "green", f"{wanted} {cause}")
            case "refused":
                state = f"left {_OPPOSITE[wanted]}" if wanted in _OPPOSITE else f"not {wanted}"
                self._add(entry, "-", f"{state}: {printable(result.reason)} ({printable(result.policy, 40)})", "yellow")
            case "contradicted" if result.witness:
                self._add(entry, "!", f"says {wanted}, but {printable(result.saw)}: not believed", "bold red")
            case _:
                self._add(entry, "!", f"should be {wanted}: {printable(result.text)}", "red")

    def _add(self, entry: JournalEntry, sign: str, words: str, style: str, key: str = "") -> None:
        self._append(sign, name_text(entry.device, self._names, entry.part), words, style, to_seconds(entry.at), key)

    def _append(self, sign: str, device: str, words: str, style: str, at: float, key: str = "") -> None:
        """Append a line; it replaces one that says the same about another device, or earlier about this one."""
        devices: tuple[str, ...] = (device,)
        recent = (line for line in reversed(self.lines) if at - line.at <= _ONE_MOMENT)
        same = next((line for line in recent if (line.sign, line.key) == (sign, key or words)), None)
        if same is not None:
            devices, words = tuple(dict.fromkeys((*same.devices, device))), same.words
            self.lines.remove(same)
        elif sign in _REPLACED and self.lines and (self.lines[-1].sign, self.lines[-1].devices) == (sign, devices):
            self.lines.pop()  # a moving cover or robot
        self.lines.append(StoryLine(sign, devices, words, style, at, self._time(), key or words))
