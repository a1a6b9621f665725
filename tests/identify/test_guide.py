"""What docs/identify.md shows works."""

import re
from collections.abc import Iterator

import pytest
from tests.guide import commands_in, guide
from tests.shell import Homebot, homebot_in

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant")]

GUIDE = guide("identify")
COMMANDS = commands_in(GUIDE)
HOUSE = """
[house]
dialect = "homeassistant"
[rooms.hall]
[devices.hall_lamp]
kind = "lamp"
room = "hall"
[devices.hall_lux]
kind = "lux"
room = "hall"
share = 0.02
"""


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    until = ("found hall_lamp", "found hall_lux", "is running")
    with homebot_in(tmp_path_factory.mktemp("house"), house=HOUSE, until=until) as homebot:
        yield homebot


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_guide_runs(home: Homebot, command: str) -> None:
    done = home.run(f"{command} --night")
    assert done.returncode == 0, done
    assert "hall_lamp is in view" in done.stdout


def test_a_command_tells_what_is_seen_and_who_holds_the_lamp(home: Homebot) -> None:
    done = home.run("homebot identify hall_lamp --with hall_lux --night")
    lines = done.stdout.splitlines()
    assert re.fullmatch(r"seen +[▁▂▃▄▅▆▇█]+", lines[-3])
    assert re.fullmatch(r"hall_lamp +·█[·█]+ +\d+\.\d%  \+[\d.]+ ± [\d.]+", lines[-2])
    assert "identify by local holds it" in home.run("homebot why hall_lamp").stdout


def test_a_sensor_that_is_not_there_is_an_error_with_the_nearest_name(home: Homebot) -> None:
    done = home.run("homebot verify hall_lamp --with hall_luxx --night")
    assert (done.returncode, done.stderr) == (
        1,
        "homebot: there is no topic /hall_luxx, nor a device with a light sensor; did you mean hall_lux?\n",
    )
