"""The judge of commands: asks the policies, with the facts that they need of the house."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from datetime import tzinfo
from functools import lru_cache
from typing import Final, final

from homebot.control.client_commands import client_refusal
from homebot.control.command import IssuedCommand
from homebot.control.journal import CommandJournal
from homebot.control.learnt_persistence import LearntPersistence
from homebot.control.policies.detections import DETECTION, Detections
from homebot.control.policies.facts import Facts
from homebot.control.policies.house import House
from homebot.control.policies.policies import Policies
from homebot.control.policies.recent_commands import RecentCommands
from homebot.control.policies.settings import PolicySettings
from homebot.control.timelines import Timelines
from homebot.devices import DeviceChange, StateChange
from homebot.devices.client_rights import ALL_RIGHTS, LOCAL_RIGHTS, ClientRights, is_client, read_scope
from homebot.devices.house_view import HouseView
from homebot.devices.outcomes import Refused
from homebot.devices.query import Query, facets_of, fits
from homebot.graph import Node

__all__ = ["Judge"]

_MOST_NAMED: Final = 5
_SET: Final = 5.0
"""Seconds by which the clock of the computer and the monotonic one come apart where it was set, or has slept."""


@final
class Judge:
    """Asks the policies about each command.

    The devices that policies need are followed; where none needs any, nothing is.

    Args:
        node: The node that follows them.
        settings: The policies.
        grants: The scope of each node that may not command everything, by its full name.
        journal: Notes the verdicts of policies that a command concerns.
        timelines: Know the changes that no command explains.
        trusts_apps: Whether nodes without a scope may command what always asks.
        detected: Motion sensors that detected somebody before.

    Attributes:
        rights: Returns the rights of an issuer, by the configuration; those of a client of the door were checked
            before. Worked out once for each of the last ones.
    """

    def __init__(
        self,
        node: Node,
        settings: PolicySettings,
        grants: Mapping[str, tuple[str, ...]],
        journal: CommandJournal,
        timelines: Timelines,
        *,
        trusts_apps: bool,
        detected: Iterable[str] = (),
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._settings = settings
        self._grants = grants
        self._journal = journal
        self._trusts_apps = trusts_apps
        self.rights = lru_cache(maxsize=256)(self._rights)
        self._policies = Policies(settings)
        self._learnt = LearntPersistence(node, journal.store)
        self._house = House(Detections(self._learnt.keeper(DETECTION)))
        self._learnt.add(DETECTION, self._house.detections)
        self._house.detections.take_over(detected)
        self._recent = RecentCommands()
        self._timelines = timelines
        self._zone = _zone(settings.time_zone)
        self._ahead = self._clock.now() - self._clock.monotonic()
        self._clock_set_at = -math.inf
        if settings.needs_house:
            node.create_task(self._follow)
        if settings.presence_guard is not None:
            node.create_task(self._learnt.load)
            journal.add_counter("detections_forgotten", lambda: self._house.detections.forgotten)

    def refusal(self, command: IssuedCommand, *, is_noted: bool = True) -> Refused | None:
        """Return the refusal of *command*; None if it may be sent now.

        Args:
            command: The command.
            is_noted: Whether the journal takes the verdicts; not for one that nobody gave yet.
        """
        now, monotonic = self._clock.now(), self._clock.monotonic()
        if abs(now - monotonic - self._ahead) > _SET:
            self._clock_set_at = monotonic
        self._ahead = now - monotonic
        facts = Facts(now, monotonic, self._zone, self._house, self._recent, self._timelines.of, self._clock_set_at)
        verdicts = self._policies.judge(command, facts)
        for verdict in verdicts:
            if is_noted and (verdict.reason or not verdict.allowed):
                self._journal.judged(command, verdict)
        last = verdicts[-1]
        return None if last.allowed else Refused(last.policy, last.reason, command_id=command.id)

    def client_refusal(self, command: IssuedCommand) -> str:
        """Return why the client that gave *command* has no right to the part, and what else it takes; empty if it has.

        See :func:`homebot.control.client_commands.client_refusal`.
        """
        return client_refusal(command, needs_approval=self._settings.approvals)

    def notes(self) -> tuple[str, ...]:
        """Return a note on the motion sensors that the presence guard does not trust yet, for people."""
        names = self._house.unproven()
        if not names:
            return ()
        named = ", ".join(names[:_MOST_NAMED]) + (", …" if len(names) > _MOST_NAMED else "")
        count = "1 motion sensor has" if len(names) == 1 else f"{len(names)} motion sensors have"
        return (f"{count} never detected anybody, so apps turn off nothing there; walk past: {named}",)

    async def detected(self) -> tuple[str, ...]:
        """Return the motion sensors that have ever detected somebody, as far as a policy needs them."""
        if self._settings.presence_guard is None:
            return ()
        await self._learnt.load()
        return self._house.detections.sensors

    def note_sent(self, command: IssuedCommand) -> None:
        """Note that *command* was sent."""
        self._recent.note(command, self._clock.monotonic())

    def _rights(self, issuer: str) -> ClientRights:
        if is_client(issuer):
            return ALL_RIGHTS
        if scope := self._grants.get(issuer):
            return read_scope(scope)
        return ALL_RIGHTS if self._trusts_apps or not self._settings.always_ask else LOCAL_RIGHTS

    async def _follow(self) -> None:
        view = HouseView.of(self._node)
        view.add(_NeededDevices(self._house, view, self._policies.needs))
        await view.wait_until_complete()
        self._house.is_known = True


@final
class _NeededDevices:
    """Watcher of the house that puts the devices which policies need into their house.

    Args:
        house: The house of the policies.
        view: The view of the node.
        needs: The query for the devices.
    """

    def __init__(self, house: House, view: HouseView, needs: Query) -> None:
        self._house = house
        self._view = view
        self._needs = needs

    def on_device(self, change: DeviceChange) -> None:
        view = self._view.get(change.device.id)
        if view is not None and fits(self._needs, facets_of(view.device)):
            self._house.put(view)
        else:
            self._house.remove(change.device.id)

    def on_values(self, change: StateChange) -> None:
        self._house.record_values(change)

    def on_event(self, change: StateChange) -> None:
        pass

    def close(self) -> None:
        pass


def _zone(name: str) -> tzinfo | None:
    if not name:
        return None
    from zoneinfo import ZoneInfo  # noqa: PLC0415 - only where the configuration has one

    return ZoneInfo(name)
