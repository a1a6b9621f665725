"""Every command of the guides to agents, control and the journal is run here; what they print has homebot's words."""

import re
import shlex
import shutil
import signal
import subprocess
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest
from tests.guide import commands_in, guide
from tests.patience import PATIENCE
from tests.shell import environment, homebot_in, run
from tests.system.attack_probe import until
from tests.whole_house import WHOLE_HOUSE

from homebot.devices.outcomes import Confirmed, Contradicted, Evidence

GUIDES = {name: guide(name) for name in ("agents", "control", "journal")}
COMMANDS = commands_in("\n".join(GUIDES.values()))

HOUSE = """
[house]
dialect = "homeassistant"
[rooms.hall]
[devices.hall_lamp]
kind = "lamp"
room = "hall"
[devices.front_door]
kind = "lock"
room = "hall"
"""

TURN_ON = """-H 'Content-Type: application/json' -d '{"device": "hall_lamp", "do": "40 %"}'"""
PRINTED: Mapping[str, tuple[int, str]] = {
    "homebot leases": (0, "nobody holds anything"),
    "homebot release 'Front door'": (1, "homebot: nobody holds front_door"),
    "homebot approve 'Front door'": (0, "front_door is approved"),
    "homebot trust 'Hall lamp'": (0, "hall_lamp was trusted already"),
    "homebot do 'Hall lamp' on": (0, "hall_lamp in "),
    "homebot do 'Hall lamp' off": (0, "hall_lamp in "),
    "homebot why 'Hall lamp'": (0, "hall_lamp is o"),
    "homebot why-not 'Hall lamp' on": (0, "hall_lamp is o"),
    "homebot token new agent --scope read --scope 'act: harmless'": (0, "the token is in agent.token"),
    "homebot token new agent --scope read --scope 'act: harmless' --scope 'ask: lock in hall'": (0, "the token is in"),
    "homebot token new butler --scope read --scope 'act: harmless' --scope 'ask: lock in hall'": (0, "the token is in"),
    "homebot answer": (0, ""),
    "homebot answer 6926f1a3-14 yes": (1, "homebot: "),
    f"curl -s {TURN_ON} localhost:9090/api/command": (0, '{"id":"hall_lamp","outcome":"'),
    "curl -s localhost:9090/api/home": (0, '{"home":"family","devices":25,"rooms":{"'),
    "curl -s 'localhost:9090/api/devices?q=light&limit=50'": (0, '{"devices":[{"id":"hall_lamp","type":"light"'),
    "curl -s localhost:9090/api/devices/hall_lamp": (0, '{"id":"hall_lamp","type":"light","room":"hall"'),
    "curl -s localhost:9090/api/why/hall_lamp": (0, '{"id":"hall_lamp","state":"o'),
    "curl -s 'localhost:9090/api/history?device=hall_lamp&since=24h&points=50'": (0, "{"),
    "curl -s localhost:9090/api/openapi.json": (0, '{"openapi":"3.1.0",'),
}
FOLLOWING = "homebot journal --follow"


@pytest.fixture(scope="module")
def locked(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The door of a house with a lamp and a lock, as the guide to control has it."""
    until = ("found hall_lamp", "found front_door", "is running")
    with homebot_in(tmp_path_factory.mktemp("house"), house=HOUSE, until=until) as homebot:
        yield homebot.door


@pytest.fixture(scope="module")
def family(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The door of the house of a reader, with its errands and apps."""
    with homebot_in(
        tmp_path_factory.mktemp("family"), "--ephemeral", until=("found hall_lamp", "is running")
    ) as homebot:
        until(lambda: "25 devices in family" in homebot.run("homebot devices").stdout or None, PATIENCE)
        yield homebot.door


def test_no_command_is_forgotten() -> None:
    assert {*COMMANDS} == {*PRINTED, FOLLOWING}


@WHOLE_HOUSE
@pytest.mark.parametrize("command", PRINTED)
def test_a_command_of_the_guides_does_what_they_say(
    command: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    code, printed = PRINTED[command]
    door = request.getfixturevalue("locked" if command in commands_in(GUIDES["control"]) else "family")
    if command.startswith("curl") and shutil.which("curl") is None:
        pytest.skip("curl is not installed")
    done = run(command.replace("localhost:9090", door), door=door, cwd=tmp_path)
    assert (done.returncode, (done.stdout + done.stderr)[: len(printed)]) == (code, printed)


@pytest.mark.rooms("homeassistant")
def test_the_journal_is_followed(locked: str) -> None:
    with subprocess.Popen(
        shlex.split(FOLLOWING), env=environment(locked), stdout=subprocess.PIPE, text=True
    ) as following:
        assert following.stdout is not None
        run("homebot do 'Hall lamp' on", door=locked)
        assert "hall_lamp" in following.stdout.readline()
        following.send_signal(signal.SIGINT)


def test_the_outcomes_shown_have_the_words_of_homebot() -> None:
    shown = re.findall(r"^Hall lamp(?: in villa)?: (.*)$", GUIDES["control"], re.MULTILINE)
    witnessed = Confirmed(0.4, Evidence.WITNESSED, "Hall lux")
    assert shown == [witnessed.text, Contradicted("Hall lux measured no change", "Hall lux").text]
