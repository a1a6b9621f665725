"""The commands and the configuration of docs/groups.md work."""

from collections.abc import Iterator

import pytest
from tests.guide import blocks_in, commands_in, guide
from tests.shell import Homebot, homebot_in
from tests.whole_house import WHOLE_HOUSE

pytestmark = [pytest.mark.slow, WHOLE_HOUSE]

GUIDE = guide("groups")
COMMANDS = commands_in(GUIDE)
(CONFIG,) = blocks_in(GUIDE, "toml")


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    """The house of a reader, with its errands, and the guide's configuration."""
    until = ("found hall_lamp", "found living_lamp", "is running")
    folder = tmp_path_factory.mktemp("house")
    (folder / "homebot.toml").write_text(f"[gateways.mqtt]\n{CONFIG}")
    with homebot_in(folder, "--house", "family", "--ephemeral", until=until) as homebot:
        yield homebot


def test_the_commands_of_the_guide_run_in_its_order(home: Homebot) -> None:
    for command in COMMANDS:
        done = home.run(command)
        assert (done.returncode, done.stdout != "") == (0, True), done
