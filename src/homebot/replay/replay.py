"""Replay of a recording: the graph, the directory, the control layer and apps, fed with recorded messages.

The same recording with the same apps and settings gives the same commands if an app depends only on the devices of the
house and its clock, and not on the network, files, chance, or the time of the computer.
"""

import json
import tomllib
from collections.abc import Awaitable, Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from random import Random
from typing import ClassVar, Final, final

import anyio

from homebot.apps import App
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
from homebot.graph import Node
from homebot.names import snake_case
from homebot.plugins import installed_plugin, is_file, load_plugin, name_in_file
from homebot.recording.lines import CommandNews, RecordedApp, RecordedCommand
from homebot.recording.recording import Recording, TimedCommand
from homebot.replay.command_diff import CommandMatcher
from homebot.replay.replay_gateway import ReplayFeed
from homebot.replay.replay_people import ReplayPeople
from homebot.runtime import Runtime

__all__ = ["Replayed", "replay", "replay_config"]

_APPS: Final = "homebot.apps"
_SHOWN: Final = 60
_MOST_SHOWN: Final = 3


def _app_tables(recorded: Iterable[RecordedApp], wanted: Sequence[str], given: dict[str, Table]) -> dict[str, Table]:
    """Return the tables ``[apps.NAME]`` of a replay.

    Args:
        recorded: The apps of the recording; only installed plug-ins are loaded, because a recording must not run other
        code.
        wanted: The apps to run: plug-ins, ``module:Class``, or Python files; empty for those of the recording. An app
        with the class name of a recorded one replaces it, and gets its name and settings.
        given: Tables of a configuration, which take precedence over the recorded settings.

    Raises:
        UsageError: An app cannot be found, or the recording is damaged.
    """
    known = tuple(recorded)
    if wanted:
        tables = _tables_of(wanted, known)
    else:
        _check_installed(known)
        tables = {one.name: _settings(one) | {"class": one.kind} for one in known}
    return {name: table | given.get(name, {}) | {"class": table["class"]} for name, table in tables.items()}


def _tables_of(wanted: Iterable[str], known: Iterable[RecordedApp]) -> dict[str, Table]:
    classes: list[type[object]] = [
        load_plugin(_APPS, name_in_file(text, App) if is_file(text) else text) for text in wanted
    ]
    kinds = {_kind_of(one) for one in classes}
    tables: dict[str, Table] = {}
    for one in classes:
        same = [app for app in known if app.kind == _kind_of(one)]
        tables |= _in_place(one, same or [app for app in known if app.kind not in kinds])
    return tables


def _check_installed(recorded: Iterable[RecordedApp]) -> None:
    others = [one for one in recorded if installed_plugin(_APPS, one.kind) is None]
    if others:
        named = ", ".join(f"{one.name} ({one.kind[:_SHOWN]})" for one in others[:_MOST_SHOWN])
        raise UsageError(
            f"the recording names apps that are not installed, and a replay runs no code that only a recording names: "
            f"{named}; name each app to run, such as --app FILE.py"
        )


def _kind_of(app: type[object]) -> str:
    return f"{app.__module__}:{app.__qualname__}"


def _in_place(app: type[object], recorded: Iterable[RecordedApp]) -> dict[str, Table]:
    """Return the tables of *app* in place of *recorded* ones with its class name; if there are none, its own."""
    same = [one for one in recorded if one.kind.rpartition(":")[2] == app.__qualname__]
    if len(kinds := sorted({one.kind for one in same})) > 1:
        named = " or ".join(kind[:_SHOWN] for kind in kinds[:_MOST_SHOWN])
        raise UsageError(f"{_kind_of(app)} may replace {named}: give its file the name of the one that it replaces")
    if same:
        return {one.name: _settings(one) | {"class": _kind_of(app)} for one in same}
    return {snake_case(app.__name__): {"class": _kind_of(app)}}


def _settings(app: RecordedApp) -> Table:
    return _recorded_table(app.settings, f"table [apps.{app.name}]")


def _recorded_table(text: str, what: str) -> Table:
    """Return the table in *text*, a JSON object.

    Raises:
        UsageError: It is not an object; the recording is damaged.
    """
    try:
        return _as_table(json.loads(text), what)
    except (ValueError, RecursionError) as exc:
        raise UsageError(f"the {what} in the recording is not JSON") from exc


def _as_table(found: object, what: str) -> Table:
    """Return *found* as a table; errors as for :func:`_recorded_table`."""
    if not isinstance(found, dict):
        raise UsageError(f"the {what} in the recording is not a table")
    return {**found}


_GATEWAY = "homebot.replay.replay_gateway:ReplayGateway"


@dataclass(frozen=True, slots=True)
class Replayed:
    """The result of a replay.

    Attributes:
        commands: The commands of apps, in order of time, each with its outcome if known.
        issuers: The full names of the apps that ran.
        crashes: The crashes of apps, by name.
        devices: The devices in the directory at the end.
    """

    commands: tuple[TimedCommand, ...]
    issuers: tuple[str, ...]
    crashes: Mapping[str, str]
    devices: tuple[Device, ...] = ()


def replay_config(recording: Recording, apps: Sequence[str] = (), given: Config | None = None) -> Config:
    """Return the configuration of a replay of *recording*.

    Args:
        apps: The apps to run, as for :func:`_app_tables`; by default the recorded ones.
        given: A configuration: its tables ``[home]``, ``[control]`` and ``[places]``, if present, and ``[discovery]``
        replace those of the recording, and its app tables replace the recorded settings.

    Raises:
        UsageError: An app cannot be found, or the recording is damaged.
    """
    header = recording.header
    base = given or Config()
    given_home = base.home.model_dump(exclude_unset=True)
    return parse_config(
        {
            "home": _recorded_table(header.home_table, "table [home]") | given_home | {"name": header.home or UNNAMED},
            "gateways": {name: {"class": _GATEWAY} for name in recording.gateways},
            "apps": _app_tables(header.apps, apps, dict(base.apps)),
            "control": base.control or _recorded_table(header.control, "table [control]"),
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
            people.cancel_scope.cancel()
            devices = (await node.create_client(FindDevices, FIND_DEVICES).call(FindDevicesRequest())).devices
    issuers = tuple(f"/{name}" for name in config.apps)
    crashes = {name: one.last for name, one in runtime.supervisor.crashes.items()}
    return Replayed(journal.commands_of(issuers), issuers, crashes, devices)


@final
class _ReplayJournal:
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
        """Return the commands of *issuers* in order of time."""
        given = sorted((one for one in self._given if one.command.issuer in issuers), key=lambda one: one.at)
        return tuple(replace(one, result=self._results.get(one.command.id)) for one in given)


def _places(text: str) -> Table:
    try:
        found = tomllib.loads(text).get("places", {})
    except (ValueError, RecursionError) as exc:
        raise UsageError(f"the table [places] in the recording is not TOML: {exc}") from exc
    return _as_table(found, "table [places]")


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
        """See :class:`homebot.control.executor.Rehearsal`."""
        found = self._matcher.pop(TimedCommand(self._now(), _recorded(command)))
        if found is None:
            return Confirmed(0.0, Evidence.SENT, command_id=command.id)
        if found.result is None:
            return None
        outcome = replace(found.result.to_outcome(), command_id=command.id)
        return None if outcome.was_sent else outcome


def _recorded(command: IssuedCommand) -> RecordedCommand:
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
        keys = tuple((one.gateway, one.key) for one in device.endpoints if (one.gateway, one.key) not in taken)
        taken.update(keys)
        if keys and device.id not in known:
            gone = Tombstone(device.id, keys, (), retained_only=False, at=recording.header.started_at.to_seconds())
            rows.append(IndexRow(table="tombstones", id=device.id, record=tombstone_record(gone)))
    return tuple(rows)
