"""Replay of a recording: the graph, the directory, the control layer and apps, fed with recorded messages.

The same recording with the same apps and settings gives the same commands if an app depends only on the devices of the
house and its clock, and not on the network, files, chance, or the time of the computer.
"""

import tomllib
from collections import deque
from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from random import Random
from typing import ClassVar, final

import anyio

from homebot.apps.notifier import Notification
from homebot.clock import LoopClock
from homebot.config import UNNAMED, Config, Table, parse_config
from homebot.control.command import IssuedCommand
from homebot.devices import FIND_DEVICES, Device, FindDevices
from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import JOURNAL_ENTRIES
from homebot.devices.outcomes import Confirmed, Evidence, Outcome
from homebot.devices.services import FindDevicesRequest, IndexRow
from homebot.devices.value import Value
from homebot.discovery.ids import Tombstone
from homebot.discovery.record import read_entry, read_tombstone, tombstone_record
from homebot.errors import UsageError, WireError
from homebot.feature import feature_tables
from homebot.graph import Node
from homebot.recording.lines import CommandNews, RecordedCommand
from homebot.recording.recording import Recording, TimedCommand
from homebot.replay.command_matcher import CommandMatcher
from homebot.replay.replay_apps import app_tables, as_table, recorded_table
from homebot.replay.replay_gateway import ReplayFeed
from homebot.replay.replay_people import ReplayPeople
from homebot.runtime import Runtime
from homebot.runtime.app_host import RehearsedAct

_GATEWAY = "homebot.replay.replay_gateway:ReplayGateway"


@dataclass(frozen=True, slots=True)
class Replayed:
    """The result of a replay.

    Attributes:
        commands: The commands of apps, in order of time, each with its outcome if known.
        issuers: The full names of the apps that ran.
        crashes: The crashes of apps, by name.
        devices: The devices in the directory at the end.
        changes: The journal's entries of changes that no command explains, at most 100,000.
        notifications: The last hundred messages of apps to people.
        acts: The last acts of robots that were only recorded.
        hints: By routine, why it cannot work in the house as it was at the end.
    """

    commands: tuple[TimedCommand, ...]
    issuers: tuple[str, ...]
    crashes: Mapping[str, str]
    devices: tuple[Device, ...] = ()
    changes: tuple[JournalEntry, ...] = ()
    notifications: tuple[Notification, ...] = ()
    hints: Mapping[str, Sequence[str]] = field(default_factory=dict)
    acts: tuple[RehearsedAct, ...] = ()


def replay_config(
    recording: Recording,
    apps: Sequence[str] = (),
    given: Config | None = None,
    tables: Mapping[str, Table] | None = None,
) -> Config:
    """Return the configuration of a replay of *recording*.

    Args:
        apps: The apps to run, as for :func:`homebot.replay.replay_apps.app_tables`; by default the recorded ones.
        given: A configuration: its tables ``[home]``, ``[control]`` and ``[places]``, if present, and ``[discovery]``
        replace those of the recording, and its app tables replace the recorded settings.
        tables: The tables of the only apps to run, instead of *apps*.

    Raises:
        UsageError: An app cannot be found, or the recording is damaged.
    """
    header = recording.header
    base = given or Config()
    given_home = base.home.model_dump(exclude_unset=True)
    return parse_config(
        {
            "home": recorded_table(header.home_table, "table [home]") | given_home | {"name": header.home or UNNAMED},
            "gateways": {name: {"class": _GATEWAY} for name in recording.gateways},
            "apps": app_tables(header.apps, apps, dict(base.apps)) if tables is None else dict(tables),
            "control": base.control or recorded_table(header.control, "table [control]"),
            "places": base.places or _places(header.places),
            "groups": list(base.groups),
            **{
                key: list(table) if isinstance(table, tuple) else table
                for key, table in base.features.items()
                if feature_tables()[key].is_live
            },
            "discovery": {key: value for key, value in base.discovery.items() if key != "prefer"},  # nothing is sent
        },
        "the recording" if given is None else f"the recording and {base.source}",
        base.folder,
    )


async def replay(recording: Recording, config: Config, settle: Callable[[], Awaitable[None]]) -> Replayed:
    """Run the apps of *config* through the recorded time, on an event loop of virtual time.

    Args:
        config: Made by :func:`replay_config`.
        settle: Returns when everything that is due now has happened.

    Raises:
        UsageError: An app cannot be started as configured, or the recording is inconsistent.
    """
    check_index(recording)
    clock = LoopClock(recording.header.started_at.to_seconds())
    feed = ReplayFeed(recording, clock, settle)
    outcomes = _RecordedOutcomes(recording.commands, lambda: feed.now)
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
            hints = {
                name: hint for _, keeper in runtime.app_host.keepers() for name, hint in (await keeper.hints()).items()
            }
            people.cancel_scope.cancel()
            devices = (await node.create_client(FindDevices, FIND_DEVICES).call(FindDevicesRequest())).devices
    issuers = tuple(f"/{name}" for name in config.apps)
    crashes = {name: crash.last for name, crash in runtime.supervisor.crashes.items()}
    notified = tuple(runtime.app_host.notifier.recent)
    acts = tuple(runtime.app_host.rehearsed)
    return Replayed(
        journal.commands_of(issuers), issuers, crashes, devices, tuple(journal.changes), notified, hints, acts
    )


@final
class _ReplayJournal:
    def __init__(self, began: float) -> None:
        self._began = began
        self._news = CommandNews()
        self._given: list[TimedCommand] = []
        self._results: dict[str, CommandResult] = {}
        self.changes: deque[JournalEntry] = deque(maxlen=100_000)

    def on_entry(self, entry: JournalEntry) -> None:
        if entry.kind == "changed":
            self.changes.append(entry)
        match self._news.of(entry):
            case RecordedCommand() as command:
                self._given.append(TimedCommand(entry.at.to_seconds() - self._began, command))
            case CommandResult() as result:
                self._results[result.command_id] = result

    def commands_of(self, issuers: Collection[str]) -> tuple[TimedCommand, ...]:
        """Return the commands of *issuers* in order of time."""
        given = sorted(
            (command for command in self._given if command.command.issuer in issuers), key=lambda command: command.at
        )
        return tuple(replace(command, result=self._results.get(command.command.id)) for command in given)


def _places(text: str) -> Table:
    try:
        table = tomllib.loads(text).get("places", {})
    except (ValueError, RecursionError) as exc:
        raise UsageError(f"the table [places] in the recording is not TOML: {exc}") from exc
    return as_table(table, "table [places]")


@final
class _RecordedOutcomes:
    """Answers commands as the recorded devices did.

    A command that was sent in the recording goes to the muted gateway, and its outcome follows from the recorded
    reports. A command that was not sent, because the device already had the value or its network was away, has its
    recorded outcome. A command that is not in the recording counts as sent and obeyed for its app until the next report
    of the device; for all others the devices keep their recorded states.
    """

    is_live: ClassVar[bool] = False

    def __init__(self, commands: Iterable[TimedCommand], now: Callable[[], float]) -> None:
        self._matcher = CommandMatcher(commands)
        self._now = now

    def outcome(self, command: IssuedCommand) -> Outcome | None:
        """See :class:`homebot.control.sending.SimulatedExecution`."""
        recorded = self._matcher.pop(TimedCommand(self._now(), _record(command)))
        if recorded is None:
            return Confirmed(0.0, Evidence.SENT, command_id=command.id)
        if recorded.result is None:
            return None
        outcome = replace(recorded.result.to_outcome(), command_id=command.id)
        return None if outcome.was_sent else outcome


def _record(command: IssuedCommand) -> RecordedCommand:
    settings = tuple(Setting(capability=name, value=Value.of(value)) for name, value in command.settings.items())
    return RecordedCommand(
        id=command.id, issuer=command.issuer, device=command.device.id, part=command.part.id, settings=settings
    )


def check_index(recording: Recording) -> None:
    """Read the rows of the index.

    Raises:
        UsageError: A row is damaged; the directory would continue without the device.
    """
    for row in recording.index:
        try:
            if row.table == "devices":
                read_entry(row.id, row.record)
            elif row.table == "tombstones":
                read_tombstone(row.id, row.record)
        except WireError as exc:
            raise UsageError(f"the recording is damaged: the row {row.id[:100]!r} of its index: {exc.problem}") from exc


def ids_to_come(recording: Recording) -> tuple[IndexRow, ...]:
    """Return later devices as removed ones in the initial index, so that they get their ids when they return.

    The id of a new device is derived from its first announcement, or, of several at one moment, perhaps from the last.
    An announcement belongs to its first device, so that devices split from it get the same ids as before.
    """
    known = {row.id for row in recording.index}
    taken: set[tuple[str, str]] = set()
    rows: list[IndexRow] = []
    for device in recording.devices.values():
        keys = tuple(
            (endpoint.gateway, endpoint.key)
            for endpoint in device.endpoints
            if (endpoint.gateway, endpoint.key) not in taken
        )
        taken.update(keys)
        if keys and device.id not in known:
            gone = Tombstone(device.id, keys, (), retained_only=False, at=recording.header.started_at.to_seconds())
            rows.append(IndexRow(table="tombstones", id=device.id, record=tombstone_record(gone)))
    return tuple(rows)
