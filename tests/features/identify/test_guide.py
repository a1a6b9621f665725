"""What docs/identify.md shows works."""

import re
from collections.abc import Iterator

import pytest
from tests.guide import commands_in, guide
from tests.shell import Homebot, homebot_in
from tests.whole_house import WHOLE_HOUSE

pytestmark = [pytest.mark.slow, WHOLE_HOUSE]

GUIDE = guide("identify")
COMMANDS = commands_in(GUIDE)


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    """The house of a reader, with its errands and apps."""
    until = ("found living_lamp", "found reading_lamp", "found living_lux", "is running")
    with homebot_in(tmp_path_factory.mktemp("house"), "--ephemeral", until=until) as homebot:
        yield homebot


@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_of_the_guide_runs(home: Homebot, command: str) -> None:
    done = home.run(f"{command} --night")
    assert done.returncode == 0, done
    assert "living_lamp is in view" in done.stdout


def test_a_command_tells_what_is_seen_and_who_holds_the_lamp(home: Homebot) -> None:
    done = home.run("homebot identify living_lamp --with living_lux --night")
    lines = done.stdout.splitlines()
    assert re.fullmatch(r"seen +[▁▂▃▄▅▆▇█]+", lines[-3])
    assert re.fullmatch(r"living_lamp +·█[·█]+ +\d+\.\d%  \+[\d.]+ ± [\d.]+", lines[-2])
    why = home.run("homebot why living_lamp").stdout  # its last change is a step, or the lamp was put back
    assert re.search("identify by local (holds it|.*, and it is put back)", why)


def test_a_sensor_that_is_not_there_is_an_error_with_the_nearest_name(home: Homebot) -> None:
    done = home.run("homebot verify living_lamp --with living_luxx --night")
    assert (done.returncode, done.stderr) == (
        1,
        "homebot: there is no topic /living_luxx, nor a device with a light sensor; did you mean living_lux?\n",
    )
