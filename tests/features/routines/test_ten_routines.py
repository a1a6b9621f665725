"""Ten routines that homes have, in the family's house, and their trial on the recorded time."""

import asyncio
import re
import tomllib
from collections import Counter
from collections.abc import Iterable

import pytest
from tests.features.routines.week import ROUTINES, Week, week

from homebot.config import Config, load_config
from homebot.features.routines.trial import trial_config
from homebot.recording.recording import Recording, TimedCommand
from homebot.replay.replay import Replayed, replay
from homebot.testing import VirtualTimeLoop

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800), pytest.mark.rooms("homeassistant", "recording")]

YAML = ROUTINES.with_name("home_assistant.yaml").read_text("utf-8")
TABLES = ROUTINES.read_text("utf-8").split("[[routines]]\n")[1:]


@pytest.fixture(scope="module")
def lived() -> Week:
    return week()


@pytest.fixture(scope="module")
def tried(lived: Week) -> Replayed:
    return replayed(lived.recording, trial_config(lived.recording, load_config(ROUTINES)))


def replayed(recording: Recording, config: Config) -> Replayed:
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        loop = runner.get_loop()
        assert isinstance(loop, VirtualTimeLoop)
        return runner.run(replay(recording, config, loop.settled))


def in_words(one: TimedCommand) -> tuple[object, ...]:
    """When, by which routine and why, and what for which device; recorded times are rounded to a microsecond."""
    command = one.command
    values = tuple((each.capability, each.value.plain()) for each in command.settings)
    trigger = command.trigger
    return round(one.at, 3), command.issuer, command.device, values, trigger.kind, trigger.device, trigger.readings


def test_each_of_them_did_its_work(lived: Week) -> None:
    days = round(lived.recording.ends_at / 86400)
    given = Counter(one.command.issuer.removeprefix("/") for one in lived.recording.commands)
    told = Counter(one.app for one in lived.notifications)
    assert given["motion_light"] >= 2 * days
    assert given["window_and_heating"] >= 2 * days
    assert given["wake_up_light"] == 3 * sum((4 + day) % 7 < 5 for day in range(days))
    assert given["blinds_by_the_sun"] == 2 * days
    assert given["vacuum_when_nobody_is_home"] == 2 * days
    assert given["night_light"] >= 2 * days
    assert given["all_off_when_leaving"] >= 8 * days
    assert given["hall_button"] >= 9 * days
    assert told == {"washer_finished": days, "door_left_open": days}
    assert len(given | told) == 10


def test_a_trial_of_them_gives_the_same_commands_because_of_the_same_triggers(lived: Week, tried: Replayed) -> None:
    assert tried.crashes == {}
    assert [*map(in_words, tried.commands)] == [*map(in_words, lived.recording.commands)]
    assert [(one.app, one.message) for one in tried.notifications] == [
        (one.app, one.message) for one in lived.notifications
    ]


def test_so_does_a_trial_by_the_history(lived: Week) -> None:
    """Its times are whole milliseconds, in which the simulated devices have obeyed already."""
    tried = replayed(lived.history, trial_config(lived.history, load_config(ROUTINES)))

    def given(commands: Iterable[TimedCommand]) -> list[str]:
        return sorted(f"{one.at:.1f} {in_words(one)[1:-1]}" for one in commands)  # each value is its own report

    assert given(tried.commands) == given(lived.recording.commands)
    assert [(one.app, one.message) for one in tried.notifications] == [
        (one.app, one.message) for one in lived.notifications
    ]


def test_nothing_is_said_against_them(tried: Replayed) -> None:
    assert dict(tried.hints) == {}


@pytest.mark.parametrize("table", TABLES)
def test_each_has_at_most_eight_lines_and_an_automation_beside_it(table: str) -> None:
    text = f"[[routines]]\n{table.strip()}\n"
    assert len(text.splitlines()) <= 8
    name = tomllib.loads(text)["routines"][0]["name"]
    assert len(re.findall(rf"^- alias: {name}$", YAML, re.MULTILINE)) == 1
