"""People in a replay: their commands, leases and requests to the directory."""

from collections import defaultdict
from collections.abc import Mapping
from typing import Any, Final, final

import anyio

from homebot.devices import names
from homebot.devices.approval_messages import ApproveDevice
from homebot.devices.client_rights import is_client
from homebot.devices.command_messages import CommandRequest, PerformCommand
from homebot.devices.lease_messages import (
    MAX_TTL,
    EndLeases,
    EndLeasesRequest,
    HolderRequest,
    HoldPart,
    HoldRequest,
    ReleaseLease,
    RenewLease,
)
from homebot.devices.places_messages import (
    AliasDevice,
    ChangeRoom,
    ImportPlaces,
    OwnerRequest,
    PlaceDevice,
    TagDevice,
    TeachPlace,
)
from homebot.devices.services import ForgetDevice, MergeDevices, SplitDevice
from homebot.errors import TypeMismatchError, UsageError
from homebot.graph import Node
from homebot.messages.json import message_from_json
from homebot.messages.message import ServiceType
from homebot.recording.lines import LeaseNews, RecordedCommand
from homebot.recording.recording import Recording, TimedCommand
from homebot.replay.command_matcher import is_carried_out
from homebot.replay.replay_gateway import ReplayFeed
from homebot.support.strict_json import parse_strict

_MAX_WAIT_S: Final = 900.0
_RENEWED_AFTER: Final = MAX_TTL / 3

OWNER_SERVICES: Final[Mapping[str, ServiceType[Any, Any]]] = {
    names.PLACE_DEVICE: PlaceDevice,
    names.ALIAS_DEVICE: AliasDevice,
    names.TAG_DEVICE: TagDevice,
    names.APPROVE_DEVICE: ApproveDevice,
    names.TEACH_PLACE: TeachPlace,
    names.CHANGE_ROOM: ChangeRoom,
    names.IMPORT_PLACES: ImportPlaces,
    names.FORGET_DEVICE: ForgetDevice,
    names.SPLIT_DEVICE: SplitDevice,
    names.MERGE_DEVICES: MergeDevices,
}
"""The services of the directory for statements of the owner about devices and rooms, by name."""


@final
class ReplayPeople:
    """Repeats the recorded actions of people at their times; refusals are ignored.

    Leases are held for as long as in the recording: they end when they were released, ended or expired there. Apps hold
    their own leases.
    """

    def __init__(self, node: Node, recording: Recording, feed: ReplayFeed) -> None:
        self._node = node
        self._recording = recording
        self._feed = feed
        self._perform = node.create_client(PerformCommand, names.PERFORM_COMMAND)
        self._hold = node.create_client(HoldPart, names.HOLD_PART)
        self._renew = node.create_client(RenewLease, names.RENEW_LEASE)
        self._release = node.create_client(ReleaseLease, names.RELEASE_LEASE)
        self._end = node.create_client(EndLeases, names.END_LEASES)
        self._held: defaultdict[tuple[str, ...], list[HolderRequest]] = defaultdict(list)
        self._number = 0

    async def run(self) -> None:
        """Give commands, and hold and release parts, until cancelled."""
        async with anyio.create_task_group() as calls:
            calls.start_soon(self._renew_all)
            for at, wish in sorted(self._wishes(), key=lambda one: one[0]):
                await anyio.sleep(max(0.0, at - self._feed.now))
                calls.start_soon(self._do, wish)

    async def ask_directory(self, request: OwnerRequest) -> None:
        """Repeat a request of the owner to the directory.

        Raises:
            UsageError: The request is invalid; the recording is damaged.
        """
        service = OWNER_SERVICES.get(request.service)
        if service is None:
            known = ", ".join(OWNER_SERVICES)
            raise UsageError(f"the recording is damaged: {request.service!r} is not one of {known}")
        try:
            parsed = parse_strict(request.request)
            wanted = message_from_json(service.Request, parsed if isinstance(parsed, dict) else {})
        except (ValueError, RecursionError, TypeMismatchError) as exc:
            raise UsageError(f"the recording is damaged: a request to {request.service}: {exc}") from exc
        client = self._node.create_client(service, request.service)
        try:
            await client.call(wanted, timeout=_MAX_WAIT_S)
        finally:
            client.close()

    def _wishes(self) -> list[tuple[float, RecordedCommand | LeaseNews]]:
        commands = [(command.at, command.command) for command in self._recording.commands if _is_given_again(command)]
        return [*commands, *(step for step in self._recording.leases if is_client(step[1].issuer))]

    async def _do(self, wish: RecordedCommand | LeaseNews) -> None:
        if isinstance(wish, RecordedCommand):
            await self._perform.call(
                CommandRequest(
                    device=wish.device,
                    part=wish.part,
                    settings=wish.settings,
                    issuer=wish.issuer,
                    scope=_scope(wish.device),
                ),
                timeout=_MAX_WAIT_S,
            )
        else:
            await self._change_lease(wish)

    async def _change_lease(self, news: LeaseNews) -> None:
        if news.step == "ended":
            await self._end.call(EndLeasesRequest(device=news.device, issuer=news.issuer))
            return
        capability = news.setting.capability
        held = self._held[news.device, news.part, capability, news.issuer, news.by]
        if news.step != "held":
            if held:
                await self._release.call(held.pop(0))
            return
        self._number += 1
        holder = HolderRequest(lease=f"replay-{self._number}", by=news.by, issuer=news.issuer)
        held.append(holder)
        await self._hold.call(
            HoldRequest(
                device=news.device,
                part=news.part,
                setting=news.setting,
                lease=holder.lease,
                by=holder.by,
                ttl=MAX_TTL,
                issuer=holder.issuer,
                scope=_scope(news.device),
            ),
            timeout=_MAX_WAIT_S,
        )

    async def _renew_all(self) -> None:
        """Renew all leases forever: the lease of a dead holder ends when it expired in the recording."""
        while True:
            await anyio.sleep(_RENEWED_AFTER)
            for holder in [holder for held in self._held.values() for holder in held]:
                await self._renew.call(holder)


def _is_given_again(given: TimedCommand) -> bool:
    """Return whether a person gave the command, except for a hold, which is repeated as a hold."""
    command = given.command
    is_for_lease = command.trigger.kind == "lease"
    return is_client(command.issuer) and bool(command.settings) and not is_for_lease and is_carried_out(given)


def _scope(device: str) -> tuple[str, ...]:
    """Return a scope that refuses nothing: commands refused for a missing right are not repeated."""
    return "act: all", f'act: id="{device}"'
