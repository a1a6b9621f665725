"""What docs/routines.md shows works."""

import re
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.guide import blocks_in, commands_in, guide
from tests.shell import Homebot, homebot_in
from tests.whole_house import WHOLE_HOUSE

import homebot
from homebot.config import load_config, parse_config
from homebot.runtime.plan import make_plan
from homebot.words.conditions import read_condition
from homebot.words.steps import read_step
from homebot.words.triggers import read_trigger

pytestmark = [pytest.mark.slow, WHOLE_HOUSE]

GUIDE = guide("routines")
COMMANDS = commands_in(GUIDE)

BUTTON = """
from homebot.devices.part import Capability, Part
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.memory import MemoryGateway

class Buttons(MemoryGateway):
    async def serve(self, *, task_status):
        press = Capability(name="press", options=("single", "double", "hold", "release"))
        part = Part(id="", service_type="generic_switch", capabilities=(press,))
        self.devices.put(GatewayDevice("hall_button", "Hall button", (part,)), "new")
        await super().serve(task_status=task_status)
"""

AUTOMATIONS = """
- alias: Evening light
  trigger: {platform: sun, event: sunset}
  action: {service: light.turn_on, entity_id: light.hall_lamp}
"""


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Homebot]:
    path = tmp_path_factory.mktemp("home")
    shown = "\n".join(blocks_in(GUIDE, "toml"))
    (path / "homebot.toml").write_text(f"{shown}\n[gateways.mqtt]\n[gateways.buttons]\nclass = 'button.py:Buttons'\n")
    (path / "button.py").write_text(BUTTON)
    (path / "automations.yaml").write_text(AUTOMATIONS)
    (path / "evening.toml").write_text('name = "Evening"\nwhen = ["22:00"]\ndo = ["hall lamp off"]\n')
    until = ("found hall_lamp", "found hall_motion", "found hall_button", "good_night")
    with homebot_in(path, "--house", "family", until=until) as homebot:
        yield homebot


def test_the_commands_of_the_guide_run_in_its_order(home: Homebot) -> None:
    for command in COMMANDS:
        done = home.run(command)
        assert (done.returncode, done.stdout != "") == (0, True), done


def test_why_tells_of_a_routine_and_a_scene_what_they_do_and_did(home: Homebot) -> None:
    assert "do   notify Good night" in home.run("homebot why 'good night'").stdout
    home.run("homebot scene save Film 'hall lamp'")
    assert home.run("homebot why Film").stdout.startswith("Film, kept by homebot\n  hall_lamp: ")


def test_its_first_example_fits_the_house_of_homebot_run() -> None:
    config = load_config(Path(homebot.__file__).parent / "house" / "family" / "home.toml")
    routines = tomllib.loads(next(iter(blocks_in(GUIDE, "toml"))))["routines"]
    assert make_plan(parse_config({**config.model_dump(), "routines": routines}, "home.toml")).left_out == {}


def test_the_texts_of_the_guide_are_read() -> None:
    when, given, steps = re.split(r"^## `(?:when|if|do)`", GUIDE, flags=re.MULTILINE)[1:]
    for text in _in_first_column(when):
        read_trigger(text)
    for text in re.findall(r"`([^`]+)`", given):
        if "homebot" not in text:
            read_condition(text)
    for text in _in_first_column(steps):
        read_step(text)


def _in_first_column(section: str) -> list[str]:
    rows = [row.split("|")[1] for row in section.splitlines() if row.startswith("| `")]
    assert len(rows) > 5
    return [text for row in rows for text in re.findall(r"`([^`]+)`", row)]
