"""Trial of routines on a recorded time: their commands then, and the changes that people made after them."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from homebot.config import Config, Table
from homebot.config_lines import located
from homebot.control.timeline.facts import Cause
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.wording.journal_words import settings_text
from homebot.errors import ConfigError, UsageError
from homebot.feature import plugin_tables
from homebot.recording.recording import Recording, TimedCommand
from homebot.replay.replay import Replayed, replay_config
from homebot.runtime.plan import plan_errors

_AGAINST: Final = 600.0
"""Seconds after a command in which a person's change of the same part says something about it."""

_EFFECT: Final = 10.0
_BY_HAND: Final = {Cause.PERSON.value, Cause.UNKNOWN.value}


@dataclass(frozen=True, slots=True)
class TriedCommand:
    """A command that a routine would have given.

    Attributes:
        seconds: How much later a person changed the same part; 0 for not within ten minutes.
        change: The new values.
    """

    given: TimedCommand
    seconds: float = 0.0
    change: str = ""


def trial_config(recording: Recording, given: Config) -> Config:
    """Return the configuration of a replay of *recording* with the routines of *given* alone.

    Raises:
        UsageError: There is none, or the recording is damaged.
        ConfigError: A routine is wrong.
    """
    routines = dict(routines_of(given))
    if not routines:
        raise UsageError(f"{given.source} has no table [[routines]]")
    config = replay_config(recording, (), given, routines)
    if errors := plan_errors(config):
        raise located(ConfigError.joined(ConfigError(given.source, one.key, one.reason) for one in errors))
    return config


def routines_of(config: Config) -> Iterator[tuple[str, Table]]:
    """Yield the tables of the routines of *config*, by the names of their apps; they are enabled for the trial."""
    for name, table in config.apps.items():
        if plugin_tables().get(str(table.get("class"))) == "routines":
            yield name, {**table, "enabled": True}


def tried(recording: Recording, replayed: Replayed) -> Iterator[TriedCommand]:
    """Yield the commands of the routines in order of time."""
    start = recording.header.started_at.to_seconds()
    by_hand = [(one.at.to_seconds() - start, one) for one in replayed.changes if one.cause in _BY_HAND]
    by_hand = [one for one in by_hand if not _is_effect(one, recording)]
    for given in replayed.commands:
        place = given.command.device, given.command.part
        later = [one for one in by_hand if given.at < one[0] <= given.at + _AGAINST]
        against = [(at, one) for at, one in later if (one.device, one.part) == place]
        if against:
            at, change = against[0]
            yield TriedCommand(given, at - given.at, settings_text(change.settings))
        else:
            yield TriedCommand(given)


def _is_effect(change: tuple[float, JournalEntry], recording: Recording) -> bool:
    """Return whether a change followed a command of the recorded time that the replay leaves out."""
    at, entry = change
    return any(0.0 <= at - one.at <= _EFFECT and one.command.device == entry.device for one in recording.commands)
