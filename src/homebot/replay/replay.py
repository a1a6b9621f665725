"""Replay of a recording: the graph, the directory, the control layer and apps, fed with recorded messages.

The same recording with the same apps and settings gives the same commands, as far as an app depends on nothing else
than the devices of the house and its clock: not on the network, on files, on chance, or on the time of the computer.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Awaitable, Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from random import Random
from typing import final

import anyio

from homebot.clock import LoopClock
from homebot.config import UNNAMED, Config, Table, parse_config
from homebot.devices import FIND_DEVICES, Device, FindDevices
from homebot.devices.command_messages import CommandResult
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import JOURNAL_ENTRIES
from homebot.devices.services import FindDevicesRequest
from homebot.errors import UsageError
from homebot.graph import Node
from homebot.recording.lines import RecordedCommand
from homebot.recording.recorded_commands import CommandNews
from homebot.recording.recording import Recording, TimedCommand
from homebot.replay.known_devices import check_index, ids_to_come
from homebot.replay.recorded_outcomes import RecordedOutcomes
from homebot.replay.replay_apps import app_tables
from homebot.replay.replay_feed import ReplayFeed
from homebot.replay.replay_people import ReplayPeople
from homebot.runtime import Runtime

__all__ = ["Replayed", "replay", "replay_config"]

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
        apps: The apps to run, as for :func:`homebot.replay.replay_apps.app_tables`; by default the recorded ones.
        given: A configuration: its tables ``[home]``, ``[control]`` and ``[places]``, where it has them, and
            ``[discovery]`` take the place of those of the recording, and its tables of apps that of their settings.

    Raises:
        UsageError: An app cannot be found, or the recording is damaged.
    """
    header = recording.header
    base = given or Config()
    given_home = base.home.model_dump(exclude_unset=True)
    return parse_config(
        {
            "home": _table(header.home_table, "home") | given_home | {"name": header.home or UNNAMED},
            "gateways": {name: {"class": _GATEWAY} for name in recording.gateways},
            "apps": app_tables(header.apps, apps, dict(base.apps)),
            "control": base.control or _table(header.control, "control"),
            "places": base.places or _places(header.places),
            "discovery": {key: value for key, value in base.discovery.items() if key != "prefer"},  # nothing is sent
        },
        "the recording" if given is None else f"the recording and {base.source}",
        base.folder,
    )


async def replay(recording: Recording, config: Config, settle: Callable[[], Awaitable[None]]) -> Replayed:
    """Run the apps of *config* through the recorded time, on an event loop of virtual time.

    Args:
        config: Made by :func:`replay_config`.
        settle: Returns when everything has happened that is due now.

    Raises:
        UsageError: An app cannot be started as it is configured, or the recording does not fit together.
    """
    check_index(recording)
    clock = LoopClock(recording.header.started_at.to_seconds())
    feed = ReplayFeed(recording, clock, settle)
    outcomes = RecordedOutcomes(recording.commands, lambda: feed.now)
    runtime = Runtime(
        config,
        with_door=False,
        clock=clock,
        services=[feed],
        random=Random(0),  # noqa: S311 - a replay has no secrets
        trusts_apps=recording.header.trusts_apps,
        rehearsal=outcomes,
        known=(*recording.index, *ids_to_come(recording)),
        detected=recording.header.detected,
    )
    async with Node(runtime.graph, "replay", namespace="/homebot") as node:
        journal = _ReplayJournal(clock.now())
        node.create_subscription(JournalEntry, JOURNAL_ENTRIES, journal.on_entry, 100_000)
        async with runtime, anyio.create_task_group() as people:
            doings = ReplayPeople(node, recording, feed)
            people.start_soon(doings.run)
            await feed.play(doings.ask_directory)
            people.cancel_scope.cancel()
            devices = (await node.create_client(FindDevices, FIND_DEVICES).call(FindDevicesRequest())).devices
    issuers = tuple(f"/{name}" for name in config.apps)
    crashes = {name: one.last for name, one in runtime.supervisor.crashes.items()}
    return Replayed(journal.commands_of(issuers), issuers, crashes, devices)


@final
class _ReplayJournal:
    """The commands that apps gave in a replay, and their results."""

    def __init__(self, began: float) -> None:
        self._began = began
        self._news = CommandNews()
        self._given: list[TimedCommand] = []
        self._results: dict[str, CommandResult] = {}

    def on_entry(self, entry: JournalEntry) -> None:
        match self._news.of(entry):
            case RecordedCommand() as command:
                self._given.append(TimedCommand(entry.at.to_seconds() - self._began, command))
            case CommandResult() as result:
                self._results[result.command_id] = result

    def commands_of(self, issuers: Collection[str]) -> tuple[TimedCommand, ...]:
        """Return the commands of *issuers* in the order of their time."""
        given = sorted((one for one in self._given if one.command.issuer in issuers), key=lambda one: one.at)
        return tuple(replace(one, result=self._results.get(one.command.id)) for one in given)


def _table(text: str, name: str) -> Table:
    try:
        found = json.loads(text)
    except (ValueError, RecursionError) as exc:
        raise UsageError(f"the table [{name}] in the recording is no JSON") from exc
    if not isinstance(found, dict):
        raise UsageError(f"the table [{name}] in the recording is no table")
    return {**found}


def _places(text: str) -> Table:
    try:
        found = tomllib.loads(text).get("places", {})
    except (ValueError, RecursionError) as exc:
        raise UsageError(f"the table [places] in the recording is no TOML: {exc}") from exc
    if not isinstance(found, dict):
        raise UsageError("the table [places] in the recording is no table")
    return {**found}
