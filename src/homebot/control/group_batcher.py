"""Commands given at once to exactly the members of a group, which one message to the group reaches."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Final, final

import anyio

from homebot.control.command import IssuedCommand, order_of
from homebot.control.policies.rights import must_ask, names_it
from homebot.control.shared_sending import SharedSending
from homebot.devices.always_ask import always_asks
from homebot.devices.client_rights import ALL_RIGHTS, CLIENT_RIGHTS
from homebot.devices.command_messages import Setting
from homebot.devices.command_sender import CommandSender
from homebot.devices.device import is_commanded
from homebot.devices.device_lookup import references
from homebot.devices.outcomes import Refused
from homebot.devices.part import check_setting
from homebot.devices.query.terms import FactIs, type_is
from homebot.devices.value_comparison import is_same
from homebot.errors import RefusedError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from homebot.control.leases import Leases
    from homebot.control.policy_engine import PolicyEngine
    from homebot.control.timelines import Timelines
    from homebot.devices import Device, DevicePart
    from homebot.devices.command_messages import CommandRequest
    from homebot.devices.device_lookup import DeviceLookup
    from homebot.graph import Node

_RECALL: Final = Setting.of("scene", True)  # noqa: FBT003 - the value of the scene

_MAX_WAIT_S: Final = 0.5
"""Seconds for which a command waits for the others that were given with it."""


@dataclass(slots=True, eq=False)
class _Batch:
    commands: list[IssuedCommand] = field(default_factory=list)
    is_complete: anyio.Event = field(default_factory=anyio.Event)


@final
class GroupBatcher:
    """Finds a group for commands that one issuer gave at once."""

    def __init__(
        self, node: Node, lookup: DeviceLookup, policies: PolicyEngine, leases: Leases, timelines: Timelines
    ) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._lookup = lookup
        self._policies = policies
        self._leases = leases
        self._timelines = timelines
        self._sender = CommandSender(node)
        self._batches: dict[tuple[str, str], _Batch] = {}

    async def join(self, command: IssuedCommand, request: CommandRequest) -> None:
        """Wait for the other commands of the batch of *request*, and let those that one group reaches share a sending.

        A command that a person must agree to does not wait, so the batch stays incomplete.
        """
        if request.ask_first or must_ask(command):
            return
        key = command.issuer, request.batch
        batch = self._batches.setdefault(key, _Batch())
        batch.commands.append(command)
        if len(batch.commands) == request.batch_size:
            del self._batches[key]
            try:
                await self._share(batch.commands)
            finally:
                batch.is_complete.set()
            return
        try:
            with anyio.move_on_after(_MAX_WAIT_S):
                await batch.is_complete.wait()
        finally:
            if self._batches.get(key) is batch:
                del self._batches[key]

    def refusal_of_members(self, group: IssuedCommand) -> Refused | None:
        """Return why rights, a lease, a policy or a missing approval refuse the command to a member of *group*.

        A right by a query that fits the group, or scene, is one to its members; but what always asks in a scene, which
        may have any values, needs its own.
        """
        is_group, is_named = group.part.part.is_group, names_it(group)
        for device, part in group.members:
            is_covered = is_named and (is_group or not always_asks(device, part))
            command = replace(group, device=device, part=part, rights=ALL_RIGHTS if is_covered else group.rights)
            problem = "" if is_covered or not group.is_client else self._policies.client_refusal(command)
            refused = Refused(CLIENT_RIGHTS, problem) if problem else self._refusal(command)
            if refused is not None:
                reason = f"its member {command.label} is refused it: {refused.reason}"
                return replace(refused, reason=reason, command_id=group.id)
        return None

    async def _share(self, commands: Sequence[IssuedCommand]) -> None:
        alike: defaultdict[object, list[IssuedCommand]] = defaultdict(list)
        for command in commands:
            if not (command.code or command.why_it_asks or command.part.part.members):
                alike[tuple(command.settings.items()), command.transition].append(command)
        batches = [commands_alike for commands_alike in alike.values() if len(commands_alike) > 1]
        groups = await self._lookup.all_known(FactIs("category", "group")) if batches else ()
        parts = [(device, part) for device in groups for part in device.parts if part.part.is_group]
        for members in batches:
            group = next((place for place in parts if self._may_carry(*place, members)), None)
            if group is not None:
                self._share_sending(members, group)
        if all(command.shared is None for command in commands):
            await self._recall(commands)

    async def _recall(self, commands: Sequence[IssuedCommand]) -> None:
        """Let *commands* share the recall of a scene with exactly their values, if a bridge or device keeps one."""
        known = await self._lookup.all_known(type_is("x_scene"))
        parts = ((device, part) for device in known for part in device.parts if part.part.values)
        scene = next((place for place in parts if self._may_recall(*place, commands)), None)
        if scene is not None:
            self._share_sending(commands, scene, _RECALL)

    def _share_sending(
        self, commands: Sequence[IssuedCommand], place: tuple[Device, DevicePart], recall: Setting | None = None
    ) -> None:
        may_send = partial(self._may_begin, commands, *place)
        shared = SharedSending(self._node, self._sender, place, len(commands), may_send, recall)
        for command in commands:
            command.shared = shared

    def _may_recall(self, device: Device, part: DevicePart, commands: Sequence[IssuedCommand]) -> bool:
        """Return whether a scene sets exactly *commands*, and may be recalled."""
        if device.reachable.state == "no" or not sets_exactly(part, commands):
            return False
        settings = {_RECALL.capability: _RECALL.value.plain()}
        recall = replace(commands[0], device=device, part=part, settings=settings, rights=ALL_RIGHTS)
        return self._refusal(recall) is None

    def _may_carry(self, device: Device, part: DevicePart, members: Sequence[IssuedCommand]) -> bool:
        """Return whether a message to a group reaches exactly *members*, may be sent, and makes sense."""
        first = members[0]
        if device.reachable.state == "no" or not reaches_exactly(part, members):
            return False
        try:
            for capability, value in first.settings.items():
                check_setting(device.id, part.part, capability, value)
        except RefusedError:
            return False
        # The right to command each member is the right to reach all by their group.
        return self._refusal(replace(first, device=device, part=part, rights=ALL_RIGHTS)) is None

    def _refusal(self, command: IssuedCommand) -> Refused | None:
        return self._refuse_held(command) or self._policies.check(command, is_recorded=False)

    async def _may_begin(self, commands: Sequence[IssuedCommand], device: Device, part: DevicePart) -> bool:
        """Return whether the group or scene has the same members as when it was chosen, and no lease has begun since.

        If so, record that a group is commanded, also for the leases of it that yield to persons.
        """
        present = await self._lookup.known(device.id)
        now = None if present is None else present.part(part.id)
        is_same = now is not None and (now.part.members, now.part.values) == (part.part.members, part.part.values)
        whole = replace(commands[0], device=device, part=part)
        if not is_same or any(map(self._refuse_held, (*commands, whole))):
            return False
        if part.part.is_group:
            self._leases.yield_to(whole, self._clock.monotonic())
            self._timelines.command_members(order_of(commands[0]), [(device, part)])
        return True

    def _refuse_held(self, command: IssuedCommand) -> Refused | None:
        is_leased = command.place in self._leases.parts
        return self._leases.refuse(command, self._clock.monotonic()) if is_leased else None


def reaches_exactly(group: DevicePart, commands: Sequence[IssuedCommand]) -> bool:
    """Return whether the members of *group* that take the settings are exactly the parts of *commands*."""
    gateways, wanted = {route.gateway for route in group.routes}, set(group.part.members)
    places, named, reached = {command.place for command in commands}, set[str](), set[tuple[str, str]]()
    for device in {command.device.id: command.device for command in commands}.values():
        for part in device.parts:
            names = wanted.intersection(references(device, part, gateways))
            settable = {capability.name for capability in part.part.capabilities if capability.settable}
            if names and is_commanded(part.part) and commands[0].settings.keys() <= settable:
                named |= names
                reached.add((device.id, part.id))
    return named == wanted and reached == places


def sets_exactly(scene: DevicePart, commands: Sequence[IssuedCommand]) -> bool:
    """Return whether the values of *scene* are exactly those of *commands*, each to another part."""
    gateways, met = {route.gateway for route in scene.routes}, set[str]()
    for command in commands:
        names = set(references(command.device, command.part, gateways))
        own = [value for value in scene.part.values if value.member in names]
        wanted = {value.capability: value.value.plain() for value in own}
        met |= {value.member for value in own}
        settings = command.settings
        if command.code or wanted.keys() != settings.keys() or command.transition != commands[0].transition:
            return False
        if not all(is_same(name, value, settings[name]) for name, value in wanted.items()):
            return False
    return met == {value.member for value in scene.part.values}
