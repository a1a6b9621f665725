"""Watch of unexplained changes, and of raw commands of other programs."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple, TypeAlias, final

from homebot.control.device_lookup import DeviceLookup
from homebot.devices import GatewayNames, RawCommand
from homebot.devices.device import ChangedSetting, ChangedSettings
from homebot.devices.names import DEVICE_SETTINGS, DIRECTORY_NODE
from homebot.devices.value import PlainValue
from homebot.graph import OTHERS, Node, QoSProfile, ReliabilityPolicy
from homebot.support.bounded_map import BoundedMap

if TYPE_CHECKING:
    from homebot.control.journal.journal import CommandJournal
    from homebot.control.timeline.cause import Attribution

__all__ = ["HouseWatch"]

_SETTINGS: Final = QoSProfile(depth=100)
"""Each message has the changes of half a second; in a flood the oldest is dropped."""

_RAW: Final = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
"""In a flood the oldest is dropped; a gateway's commands never wait for the journal."""

_MOST_COMMANDS: Final = 10
"""The newest raw commands of one device."""

_DELAY: Final = 0.2
"""Seconds by which the journal may receive a raw command later than the gateway if the event loop is busy."""

_MOST: Final = 100_000
_CALM: Final = 10.0
"""Seconds in which further numbers of one setting are not recorded: from a dial that is turned, or a moving blind."""

_Place: TypeAlias = tuple[str, str, str]


class RawWindow(NamedTuple):
    """The time during which a raw command explains changes of its device, in seconds since the Unix epoch.

    Attributes:
        id: The id of the command; empty for none.
    """

    id: str = ""
    began: float = 0.0
    until: float = 0.0
    text: str = ""

    def means(self, value: PlainValue) -> bool:
        """Return whether the command is the usual text for *value*."""
        if isinstance(value, bool):
            return self.text == ("on" if value else "off")
        return isinstance(value, str) and self.text == value.casefold()


_NONE: Final = RawWindow()


def _is_change(before: PlainValue, before_at: float, value: PlainValue, at: float) -> bool:
    is_dial = isinstance(value, float) and before and value and at - before_at < _CALM
    return before is not None and before != value and not is_dial


@final
class HouseWatch:
    """Records unexplained changes and raw commands in the journal.

    The first value of each setting is not a change. At most 100,000 values, and as many devices with recent raw
    commands, are stored; the least recently used are dropped.

    Args:
        journal: Returns the journal, which is built when the first entry is recorded.
        cause_of: Returns the cause of a change; None if no command was ever given to the part.
        is_dry_run: Whether gateways send nothing, so raw commands have no effect.
    """

    def __init__(
        self,
        node: Node,
        lookup: DeviceLookup,
        journal: Callable[[], CommandJournal],
        cause_of: Callable[[ChangedSetting], Attribution | None],
        *,
        is_dry_run: bool = False,
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._journal = journal
        self._is_dry_run = is_dry_run
        self._cause_of = cause_of
        self._raw: BoundedMap[str, deque[RawWindow]] = BoundedMap(_MOST)
        self._values: BoundedMap[_Place, tuple[PlainValue, float]] = BoundedMap(_MOST)

    def follow_settings(self) -> None:
        """Record changes of settings from now on."""
        self._node.create_subscription(
            ChangedSettings, DEVICE_SETTINGS, self._on_settings, _SETTINGS, from_node=DIRECTORY_NODE
        )

    def follow_gateway(self, gateway: str) -> None:
        """Record the raw commands to a gateway from now on."""
        out = GatewayNames(gateway).out
        self._node.create_subscription(RawCommand, out, partial(self._on_raw, gateway), _RAW, from_node=OTHERS)

    def begin_raw(self, device: str, command: str, text: str, now: float, until: float) -> None:
        """Add a raw command that explains changes of the device from *now* to *until*."""
        known = self._raw[device] = self._raw.get(device) or deque(maxlen=_MOST_COMMANDS)
        known.append(RawWindow(command, now - _DELAY, until, text.strip().casefold()))

    def _on_settings(self, changed: ChangedSettings) -> None:
        for change in changed.changes:
            place, value = (change.device, change.part, change.capability), change.value.plain()
            if value is None:
                continue  # it says nothing; the known value counts until the next
            at, (before, before_at) = change.told_at.to_seconds(), self._values.get(place, (None, 0.0))
            self._values[place] = value, at
            if not _is_change(before, before_at, value, at):
                continue
            raw, attribution = self._explaining(change.device, value, at), self._cause_of(change)
            if raw.id and raw.means(value):
                self._journal().changed(change, before, raw.id, "command")
            elif attribution is None or attribution.role is None:  # else the entries of a command record it
                cause = "person" if attribution is None else attribution.cause.value
                self._journal().changed(change, before, raw.id, "command" if raw.id else cause)

    def _explaining(self, device: str, value: PlainValue, at: float) -> RawWindow:
        """Return the newest raw command that may explain a report; an empty one if there is none."""
        raw = [one for one in self._raw.get(device, ()) if one.began <= at <= one.until]
        meant = [one for one in raw if one.means(value)] or raw
        return max(meant, key=lambda one: one.began, default=_NONE)

    async def _on_raw(self, gateway: str, command: RawCommand) -> None:
        if command.command_id:
            return  # the control layer sent it and recorded it
        now = self._clock.now()
        device = await self._lookup.device_at(gateway, command.address)
        if device:
            self._journal().published(device, command, now, is_sent=not self._is_dry_run)
