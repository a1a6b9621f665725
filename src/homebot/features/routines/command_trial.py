"""``homebot routine try``: prints a trial of routines on recorded days."""

import argparse
import asyncio
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

from homebot.apps.grants import without_act
from homebot.cli.door_client import DoorClient, with_client
from homebot.config import Config, HomeSettings, load_config, parse_config, parse_settings, read_all
from homebot.config_lines import located
from homebot.devices.device import part_names
from homebot.devices.names import HOME_PLACE, LIST_ROUTINES
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import age_text
from homebot.errors import ConfigError, PeerError, UsageError
from homebot.features.routines.checks import asked_about
from homebot.features.routines.command_history import read_house_history
from homebot.features.routines.program import program_of
from homebot.features.routines.settings import RoutineSettings
from homebot.features.routines.text import read_routines
from homebot.features.routines.trial import TriedCommand, routines_of, trial_config, tried
from homebot.log import configure_logging
from homebot.recording.recording import Recording, load_recording
from homebot.replay.command_matcher import command_text
from homebot.replay.replay import Replayed, replay
from homebot.support.printable import printable
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.units import MAX_WAIT, parse_duration
from homebot.words.conditions import Matches
from homebot.words.steps import APPLY, Do
from homebot.words.triggers import Becomes, MessageComes, RobotArrival

if TYPE_CHECKING:
    from homebot.devices.app_messages import HomePlaceResponse, RoutinesResponse

_ALL_SEEN: Final[Mapping[str, Sequence[str]]] = {}

LAST: Final = {"last-day": 86_400.0, "last-week": 7 * 86_400.0}


def try_routines(options: argparse.Namespace) -> int:
    """Replay each recording with the routines of the file, and print their commands; nothing is sent."""
    try:
        given = load_config(Path(options.file))
        _settings(given)
    except ConfigError as exc:
        raise located(exc) from None
    for source in options.on or ["last-week"]:
        if seconds := _seconds(source):
            _try_on_history(options, given, seconds, source)
        else:
            _print(trial_lines(source, load_recording(Path(source)), given))
    return 0


def _settings(given: Config) -> dict[str, RoutineSettings]:
    """Return the routines of *given* by the names of their apps; raise ConfigError with all mistakes."""
    tables = dict(routines_of(given))
    read = [
        partial(parse_settings, RoutineSettings, without_act(one), given.source, f"routines.{app}")
        for app, one in tables.items()
    ]
    return dict(zip(tables, read_all(read), strict=True))


def _seconds(source: str) -> float:
    """Return the seconds of history that *source* means; 0 for a recording.

    Raises:
        UsageError: There is neither.
    """
    if source in LAST or (source and Path(source).exists()):
        return LAST.get(source, 0.0)
    with suppress(UsageError):
        if seconds := parse_duration(source, most=MAX_WAIT):
            return seconds
    raise UsageError(f"--on {source!r}: neither a recording nor a time; write it like last-week, last-day, 3d or 12h")


def _print(lines: Iterable[str]) -> None:
    for line in lines:
        print(line)


def _try_on_history(options: argparse.Namespace, given: Config, seconds: float, title: str) -> None:
    """Print a trial of the routines of *given* in the last *seconds* of a running homebot."""

    def show(door: DoorClient, _: argparse.Namespace) -> int:
        _print(history_lines(door, given, seconds, title))
        return 0

    with_client(options, show)


def history_lines(door: DoorClient, given: Config, seconds: float, title: str) -> list[str]:
    """Return the lines of a trial of the routines of *given* in the last *seconds* of the house behind *door*.

    Raises:
        HomebotError: No history is kept, or a routine is wrong or crashed.
    """
    read = _settings(given)
    recording = read_house_history(door, seconds, asked_about(read.values()))
    unseen = {key: [text for text, kind in one.asked() if _is_unkept(kind)] for key, one in read.items()}
    return trial_lines(title, recording, _in_home(door, given, read.values()), unseen)


def _is_unkept(asked: object) -> bool:
    """Return whether the history lacks what a routine asks for."""
    state = asked.state if isinstance(asked, Matches) else asked
    return isinstance(state, RobotArrival | MessageComes) or (isinstance(state, Becomes) and state.is_of_reach)


def given_of(text: str, source: str) -> Config:
    """Return the routines in *text* as a configuration.

    Raises:
        ConfigError: A routine is wrong.
    """
    routines = [{**routine.table, "name": routine.name} for routine in read_routines(text, source)]
    return parse_config({"routines": routines}, source)


def _in_home(door: DoorClient, given: Config, routines: Iterable[RoutineSettings]) -> Config:
    """Return *given* with the zone, and the place if this client may know it, of the home behind *door*.

    Raises:
        PeerError: It may not, and some of *routines* ask the sun.
    """
    home: dict[str, object] = {"zone": cast("RoutinesResponse", JsonMessage(door.call(LIST_ROUTINES, {}))).zone}
    try:
        place = cast("HomePlaceResponse", JsonMessage(door.call(HOME_PLACE, {}))).place
        home |= zip(("latitude", "longitude"), place, strict=False)
    except PeerError:
        if given.home.latitude is None and any(one.asking_the_sun() for one in routines):
            raise
    return given.model_copy(
        update={"home": HomeSettings.model_validate(home | given.home.model_dump(exclude_unset=True))}
    )


def trial_lines(
    title: str, recording: Recording, given: Config, unseen: Mapping[str, Sequence[str]] = _ALL_SEEN
) -> list[str]:
    """Return the lines of a trial of the routines of *given* in the time of *recording*, and last a summary of each.

    Args:
        unseen: The texts of each routine that ask for things that the recording lacks.

    Raises:
        ConfigError: A routine is wrong.
        UsageError: A routine crashed.
    """
    configure_logging(level="critical")
    config = trial_config(recording, given)
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        loop = runner.get_loop()
        assert isinstance(loop, VirtualTimeLoop)  # noqa: S101 - for the type checker: it was made the line before
        replayed = runner.run(replay(recording, config, loop.settled))
    if replayed.crashes:
        name, error = next(iter(replayed.crashes.items()))
        raise UsageError(f"{name} crashed: {error}")
    found = tuple(tried(recording, replayed))
    toggling = {f"/{app}" for app, one in _settings(given).items() if _only_toggles(one)}
    return [*_lines(recording, replayed, found, toggling), *_summary(title, replayed, found, unseen)]


def _only_toggles(routine: RoutineSettings) -> bool:
    """Return whether *routine* toggles, and switches nothing on or off by name."""
    words = {line.step.command.casefold() for line in program_of(routine.do) if isinstance(line.step, Do)}
    return "toggle" in words and words.isdisjoint({"on", "off", APPLY})


def _lines(
    recording: Recording, replayed: Replayed, commands: Sequence[TriedCommand], toggling: Collection[str]
) -> Iterator[str]:
    """Yield the commands and the messages to people in order of time, and then the hints.

    Args:
        toggling: The issuers that only toggle: the recorded state decides, which they do not change.
    """
    start, names = recording.header.started_at.to_seconds(), part_names(replayed.devices)
    lines = [
        (
            notification.time.timestamp(),
            f"{_stamp(notification.time)}  told people: {printable(notification.text)}  {notification.app}",
        )
        for notification in replayed.notifications
    ]
    lines += [
        (
            action.at,
            f"{_stamp(datetime.fromtimestamp(action.at, UTC))}  would send: {printable(action.text)}  {action.app}",
        )
        for action in replayed.acts
    ]
    for command in commands:
        later = f"; {age_text(command.seconds)} later somebody: {printable(command.change)}" if command.change else ""
        is_switched = [setting.capability for setting in command.given.command.settings] == ["on_off"]
        toggled = "; toggled from what it was then" if is_switched and command.given.command.issuer in toggling else ""
        lines.append((start + command.given.at, f"{command_text(command.given, start, names)}{toggled}{later}"))
    yield from (line for _, line in sorted(lines))
    for name, hints in replayed.hints.items():
        yield from (f"{printable(name)}: {printable(hint, 500)}" for hint in hints)


def _times(count: int) -> str:
    return "once" if count == 1 else f"{count:,} times"


def _stamp(at: datetime) -> str:
    return f"{at.astimezone():%Y-%m-%d %H:%M:%S}"


def _further(replayed: Replayed, app: str) -> str:
    told, sent = (sum(action.app == app for action in acts) for acts in (replayed.notifications, replayed.acts))
    people = f", and told people {_times(told)}" if told else ""
    return people + (f", and sent a robot {_times(sent)}" if sent else "")


def _summary(
    title: str, replayed: Replayed, found: Sequence[TriedCommand], unseen: Mapping[str, Sequence[str]]
) -> Iterator[str]:
    commands = Counter(one.given.command.issuer for one in found)
    changed = Counter(one.given.command.issuer for one in found if one.change)
    for issuer in replayed.issuers:
        count, against = commands[issuer], changed[issuer]
        given = "1 command" if count == 1 else f"{count:,} commands"
        given += f", {against:,} of which somebody changed within ten minutes" if against else ""
        app = issuer.removeprefix("/")
        missed = ", ".join(map(repr, unseen.get(app, ())))
        rest = f"; the history does not have {missed}: record some days for that (homebot record)" if missed else ""
        yield f"{printable(title)}: {app} would have given {given}{_further(replayed, app)}{printable(rest, 500)}"
