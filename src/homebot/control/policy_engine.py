"""Policy engine: checks commands against the policies and the facts of the house."""

import math
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache, partial
from typing import Final, TypeAlias, final
from zoneinfo import ZoneInfo

from homebot.control.command import IssuedCommand
from homebot.control.journal.journal import CommandJournal
from homebot.control.learnt import LearntPersistence
from homebot.control.policies.facts import Facts, Verdict
from homebot.control.policies.house import DETECTION, Detections, House
from homebot.control.policies.lift import check_lift
from homebot.control.policies.rights import check_approval, check_grants, client_refusal
from homebot.control.settings import PolicySettings
from homebot.control.timelines import Timelines
from homebot.devices import Device, DeviceChange, KeyValue, StateChange
from homebot.devices.always_ask import always_asks, waits_for_approval, why_device_asks
from homebot.devices.approval_messages import UnapprovedRequest, UnapprovedResponse
from homebot.devices.client_rights import ALL_RIGHTS, APP_RIGHTS, ClientRights, CurrentGrants, is_client
from homebot.devices.device import is_commanded
from homebot.devices.device_lookup import DeviceLookup
from homebot.devices.harmless import why_not_harmless
from homebot.devices.house_view import HouseView, HouseWatcher
from homebot.devices.outcomes import Refused
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.terms import IsUnapproved, Or
from homebot.devices.robot_ways import RobotWays
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.words.rights import read_scope

_MAX_NAMED: Final = 5
_MAX_CLOCK_DRIFT_S: Final = 5.0
"""Seconds by which the computer's clock and the monotonic one must drift apart to show that it was set, or slept."""

Policy: TypeAlias = Callable[[IssuedCommand, Facts], Verdict]


@final
class PolicyEngine(HouseWatcher):
    """Checks commands against the policies; follows the devices that these need.

    Args:
        grants: The scopes of nodes in force.
        trusts_apps: Whether nodes without a scope may command devices that always ask.

    Attributes:
        rights: Returns the rights of an issuer according to the configuration; :meth:`client_refusal` checks those of a
            client of the door.
    """

    def __init__(
        self,
        node: Node,
        lookup: DeviceLookup,
        settings: PolicySettings,
        grants: CurrentGrants,
        journal: CommandJournal,
        learnt: LearntPersistence,
        timelines: Timelines,
        *,
        trusts_apps: bool,
        detected: Iterable[str] = (),
    ) -> None:
        self._node = node
        self._lookup = lookup
        self._clock = node.graph.clock
        self._settings = settings
        self._grants = grants
        self._watches = False
        self._ways: RobotWays | None = None
        self._journal = journal
        self._trusts_apps = trusts_apps
        self.rights = lru_cache(maxsize=256)(self._rights)
        self._learnt = learnt
        self._house = House(Detections(learnt.saver(DETECTION)))
        self._house.detections.add(detected)
        self._timelines = timelines
        self._ahead = self._clock.now() - self._clock.monotonic()
        self._clock_set_at = -math.inf
        self.update(settings)

    def update(self, settings: PolicySettings) -> None:
        """Use the policies of *settings*, and the grants in force."""
        self._settings, self._policies = settings, Policies(settings)
        self._zone = ZoneInfo(settings.time_zone) if settings.time_zone else None
        self.rights.cache_clear()
        if self._watches or settings.needs_house:
            if not self._watches:
                self._watches = True
                self._node.create_task(self._await_house)
            HouseView.of(self._node).add(self)
        if settings.presence_guard is not None and self._ways is None:
            self._ways = RobotWays(self._node)
            self._learnt.add(DETECTION, self._house.detections.restore)
            self._node.create_task(self._learnt.load)

    def check(self, command: IssuedCommand, *, is_recorded: bool = True) -> Refused | None:
        """Return the refusal of *command*; None if it may be sent now.

        Args:
            is_recorded: Whether the journal records the verdicts; False for a preview.
        """
        now, monotonic = self._clock.now(), self._clock.monotonic()
        if abs(now - monotonic - self._ahead) > _MAX_CLOCK_DRIFT_S:
            self._clock_set_at = monotonic
        self._ahead = now - monotonic
        facts = Facts(now, monotonic, self._zone, self._house, self._timelines.of, clock_set_at=self._clock_set_at)
        if self._ways is not None:
            facts = facts._replace(robot_in=self._ways.robot_in)
        verdicts = self._policies.check(command, facts)
        for verdict in verdicts:
            if is_recorded and (verdict.reason or not verdict.allowed):
                self._journal.record_verdict(command, verdict)
            if is_recorded and verdict.warns:
                command.warnings[verdict.policy] = verdict.reason
        last = verdicts[-1]
        return None if last.allowed else Refused(last.policy, last.reason, command_id=command.id)

    def client_refusal(self, command: IssuedCommand) -> str:
        """Return why the client that gave *command* has no right to the part, and the remedy; empty if it has one."""
        return client_refusal(command, needs_approval=self._settings.approvals)

    @property
    def counts(self) -> dict[str, int]:
        """The counters for the health of the node, by name."""
        return {"detections_forgotten": self._house.detections.forgotten} if self._ways is not None else {}

    async def unapproved(self, request: UnapprovedRequest) -> UnapprovedResponse:
        """Return the devices that wait for the owner's approval, and the reasons why devices always ask."""
        if request.device:
            device = await self._lookup.device(request.device)
            devices = [] if device is None else [device]
        else:
            devices = await self._waiting()
        parts = [(device, part) for device in devices[:1] for part in device.parts if request.device]
        limits = (
            KeyValue(key=part.id, value=why)
            for device, part in parts
            if is_commanded(part.part) and not always_asks(device, part) and (why := why_not_harmless(device, part))
        )
        return UnapprovedResponse(
            devices=tuple(device.id for device in devices if self._settings.approvals and waits_for_approval(device)),
            reasons=tuple(KeyValue(key=device.id, value=why) for device in devices if (why := why_device_asks(device))),
            limits=tuple(limits),
        )

    async def _waiting(self) -> list[Device]:
        return list(await self._lookup.devices(IsUnapproved())) if self._settings.approvals else []

    async def approval_notes(self) -> tuple[str, ...]:
        """Return a note on the devices that wait for approval; none if the directory does not answer."""
        try:
            waiting = [f"{device.id} ({why_device_asks(device)})" for device in await self._waiting()]
        except ServiceError:
            return ()
        if not waiting:
            return ()
        count = "1 device waits for approval" if len(waiting) == 1 else f"{len(waiting)} devices wait for approval"
        return (f"{count}, and nothing is sent before (`homebot approve DEVICE`): {_first_of(waiting)}",)

    def notes(self) -> tuple[str, ...]:
        """Return a note on the motion sensors that the presence guard does not trust yet."""
        names = self._house.unproven() if self._settings.presence_guard is not None else ()
        if not names:
            return ()
        count = "1 motion sensor has" if len(names) == 1 else f"{len(names)} motion sensors have"
        return (f"{count} never detected anybody, so apps turn nothing off there; walk past: {_first_of(names)}",)

    async def detected(self) -> tuple[str, ...]:
        """Return the motion sensors that have ever detected a person; none if no policy needs them."""
        if self._settings.presence_guard is None:
            return ()
        await self._learnt.load()
        return self._house.detections.sensors

    def on_device(self, change: DeviceChange) -> None:
        """See :class:`HouseWatcher`."""
        view = HouseView.of(self._node).get(change.device.id)
        if view is not None and fits(self._policies.needs, facets_of(view.device)):
            self._house.put(view)
        else:
            self._house.remove(change.device.id)

    def on_values(self, change: StateChange) -> None:
        """See :class:`HouseWatcher`."""
        self._house.record_values(change)

    def _rights(self, issuer: str) -> ClientRights:
        if is_client(issuer):
            return ALL_RIGHTS
        granted = self._grants.now
        if scope := granted.scopes.get(issuer):
            return read_scope(scope)._replace(table=granted.tables.get(issuer, ""))
        if self._trusts_apps or not self._settings.always_ask:
            return ALL_RIGHTS
        return APP_RIGHTS._replace(table=granted.tables.get(issuer, ""))

    async def _await_house(self) -> None:
        await HouseView.of(self._node).wait_until_complete()
        self._house.is_known = True


@final
class Policies:
    """The policies of the settings: first rights, then dangers, then times.

    Attributes:
        needs: The query for the devices whose values some policy needs.
    """

    def __init__(self, settings: PolicySettings) -> None:
        tables = tuple(settings.tables())
        rights: tuple[Policy, ...] = (partial(check_grants, settings.approvals),)
        rights += (check_approval,) if settings.approvals else ()
        self._policies = (*rights, *(table.judge for table in tables))
        self._policies_of_lifts = (*rights, check_lift, *self._policies[len(rights) :])
        self.needs = Or(tuple(table.needs for table in tables if table.needs is not None))

    def check(self, command: IssuedCommand, facts: Facts) -> tuple[Verdict, ...]:
        """Return the verdicts up to and including the first refusal."""
        verdicts: list[Verdict] = []
        for policy in self._policies_of_lifts if "floor" in command.settings else self._policies:
            verdicts.append(policy(command, facts))
            if not verdicts[-1].allowed:
                break
        return tuple(verdicts)


def _first_of(names: Sequence[str]) -> str:
    return ", ".join(names[:_MAX_NAMED]) + (", …" if len(names) > _MAX_NAMED else "")
