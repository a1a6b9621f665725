"""Replay of a recording: the graph, the directory, the control layer and apps, fed with what was recorded.

The same recording with the same apps and settings gives the same commands, as far as an app depends on nothing else
than the devices of the house and its clock: not on the network, on files, on chance, or on the time of the computer.
"""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from random import Random

import anyio

from homebot.clock import LoopClock
from homebot.config import UNNAMED, Config, Table, parse_config
from homebot.devices import FIND_DEVICES, Device, FindDevices
from homebot.devices.approval import APPROVED
from homebot.devices.approval_messages import ApproveDevice, ApproveDeviceRequest
from homebot.devices.client_rights import is_client
from homebot.devices.command_messages import CommandRequest, CommandResult, PerformCommand
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import APPROVE_DEVICE, IMPORT_PLACES, JOURNAL_ENTRIES, PERFORM_COMMAND
from homebot.devices.places_messages import ImportPlaces, ImportPlacesRequest
from homebot.devices.services import FindDevicesRequest
from homebot.errors import UsageError
from homebot.graph import Graph, Node
from homebot.recording.lines import RecordedCommand
from homebot.recording.recorded_commands import CommandNews
from homebot.recording.recording import Recording, TimedCommand
from homebot.replay.command_matcher import is_carried_out
from homebot.replay.recorded_outcomes import RecordedOutcomes
from homebot.replay.replay_apps import app_tables
from homebot.replay.replay_feed import ReplayFeed
from homebot.runtime import Runtime

__all__ = ["Replayed", "replay", "replay_config"]

_LONGEST = 900.0

_GATEWAY = "homebot.replay.replay_gateway:ReplayGateway"


@dataclass(frozen=True, slots=True)
class Replayed:
    """The result of a replay.

    Attributes:
        commands: The commands that apps gave, in the order of time, each with its outcome where that is known.
        issuers: The full names of the apps that ran.
        crashes: How each app crashed that did, by its name.
        devices: The devices as the directory knew them at the end.
    """

    commands: tuple[TimedCommand, ...]
    issuers: tuple[str, ...]
    crashes: Mapping[str, str]
    devices: tuple[Device, ...] = ()


def replay_config(recording: Recording, apps: Sequence[str] = (), given: Config | None = None) -> Config:
    """Return the configuration of a replay of *recording*.

    Args:
        recording: The recording.
        apps: The apps to run, as for :func:`homebot.replay.replay_apps.app_tables`; by default the recorded ones.
        given: A configuration: its table ``[control]``, where it has one, and ``[discovery]`` take the place of those
            of the recording, and its tables of apps that of their settings.

    Raises:
        UsageError: An app cannot be found, or the recording is damaged.
    """
    header = recording.header
    base = given or Config()
    return parse_config(
        {
            "home": {"name": header.home or UNNAMED},
            "gateways": {name: {"class": _GATEWAY} for name in recording.gateways},
            "apps": app_tables(header.apps, apps, dict(base.apps)),
            "control": base.control or _table(header.control),
            "discovery": base.discovery,
        },
        "the recording" if given is None else f"the recording and {base.source}",
        base.folder,
    )


async def replay(recording: Recording, config: Config, settle: Callable[[], Awaitable[None]]) -> Replayed:
    """Run the apps of *config* through the recorded time, on an event loop of virtual time.

    Args:
        recording: The recording.
        config: Made by :func:`replay_config`.
        settle: Returns when everything has happened that is due now.

    Raises:
        UsageError: An app cannot be started as it is configured, or the recording does not fit together.
    """
    clock = LoopClock(recording.header.started_at.to_seconds())
    feed = ReplayFeed(recording, clock, settle)
    outcomes = RecordedOutcomes(recording.commands, lambda: feed.now)
    given: list[TimedCommand] = []
    results: dict[str, CommandResult] = {}
    runtime = Runtime(
        config,
        with_door=False,
        clock=clock,
        services=[feed],
        random=Random(0),  # noqa: S311 - a replay has no secrets
        trusts_apps=recording.header.trusts_apps,
        rehearsal=outcomes,
        prepare=partial(_prepare, recording),
    )
    async with Node(runtime.graph, "replay", namespace="/homebot") as node:
        began, news = clock.now(), CommandNews()

        def take(entry: JournalEntry) -> None:
            match news.of(entry):
                case RecordedCommand() as command:
                    given.append(TimedCommand(entry.at.to_seconds() - began, command))
                case CommandResult() as result:
                    results[result.command_id] = result

        node.create_subscription(JournalEntry, JOURNAL_ENTRIES, take, 100_000)
        async with runtime, anyio.create_task_group() as people:
            people.start_soon(_give_wishes, node, recording, feed)
            await feed.play()
            people.cancel_scope.cancel()
            devices = (await node.create_client(FindDevices, FIND_DEVICES).call(FindDevicesRequest())).devices
    issuers = tuple(f"/{name}" for name in config.apps)
    given.sort(key=lambda one: one.at)
    commands = [replace(one, result=results.get(one.command.id)) for one in given if one.command.issuer in issuers]
    crashes = {name: one.last for name, one in runtime.supervisor.crashes.items()}
    return Replayed(tuple(commands), issuers, crashes, devices)


async def _prepare(recording: Recording, graph: Graph) -> None:
    """Let the directory know what the owner had stated."""
    async with Node(graph, "replay_preparation", namespace="/homebot") as node:
        if recording.header.places:
            places = node.create_client(ImportPlaces, IMPORT_PLACES)
            answer = await places.call(ImportPlacesRequest(text=recording.header.places, replaces=True))
            if not answer.success:
                raise UsageError(f"the places in the recording cannot be used: {answer.message}")
        approve = node.create_client(ApproveDevice, APPROVE_DEVICE)
        for device in recording.devices.values():
            if _is_approved(device):
                await approve.call(ApproveDeviceRequest(device=device.id))


async def _give_wishes(node: Node, recording: Recording, feed: ReplayFeed) -> None:
    """Give the commands of people, each at its time; those that were refused need no answer."""
    perform = node.create_client(PerformCommand, PERFORM_COMMAND)

    async def give(command: RecordedCommand) -> None:
        await perform.call(
            CommandRequest(
                device=command.device,
                part=command.part,
                settings=command.settings,
                issuer=command.issuer,
                scope=("act: all", f'act: id="{command.device}"'),
            ),
            timeout=_LONGEST,
        )

    async with anyio.create_task_group() as calls:
        for wish in recording.commands:
            if is_client(wish.command.issuer) and wish.command.settings and is_carried_out(wish):
                await anyio.sleep(max(0.0, wish.at - feed.now))
                calls.start_soon(give, wish.command)


def _is_approved(device: Device) -> bool:
    return any(fact.name == APPROVED for fact in device.facts)


def _table(text: str) -> Table:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as exc:
        raise UsageError("the table [control] in the recording is no JSON") from exc
    if not isinstance(found, dict):
        raise UsageError("the table [control] in the recording is no table")
    return {**found}
