"""The guide for robots says what is there: every field of every service, and commands and programs that run."""

import json
import re
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from tests.guide import blocks_in, commands_in, guide
from tests.patience import PATIENCE
from tests.shell import Homebot, homebot_in, run
from tests.system.attack_probe import until
from websockets.sync.client import connect

from homebot.bridges.rosbridge.types import own_modules
from homebot.messages.definition import fields_of
from homebot.messages.interfaces import Interfaces
from homebot.messages.interfaces.interface_text import messages_in

ROOT = Path(__file__).parents[1]
GUIDE = guide("robots")
KNOWN = Interfaces()
KNOWN.add_modules("homebot", own_modules())
PROGRAM = "\n".join(blocks_in(GUIDE, "python"))
COMMANDS = [command for block in blocks_in(GUIDE, "console") for command in commands_in(block)]
BEFORE_IT_RUNS = ("homebot token", "homebot router --certificate")
"""These change the configuration, which is read at the start."""


def rows(kind: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the types of homebot's own that a table states the fields of, with the cells after them."""
    for line in GUIDE.splitlines():
        first, *cells = [cell.strip() for cell in line.strip("|").split("|")]
        if line.startswith("|"):
            for name in re.findall(rf"`homebot/{kind}(\w+)`", first):
                yield f"homebot/{kind}{name}", cells


def missing(ros_type: str, cells: list[str]) -> list[str]:
    find = KNOWN.find_action if "/action/" in ros_type else KNOWN.find_service
    messages = messages_in(find(ros_type))
    assert len(messages) == len(cells)
    order = (0, 2, 1) if len(cells) == 3 else (0, 1)  # the feedback of an action comes before its result
    return [
        f"{ros_type}: {field.name}"
        for index, cell in zip(order, cells, strict=True)
        for field in fields_of(messages[index])
        if f"`{field.name}`" not in cell and not cell.startswith("as ")
    ]


@pytest.mark.rooms("goals", "identify")
def test_every_field_of_every_service_and_action_is_in_its_row() -> None:
    services, actions = [*rows("")], [*rows("action/")]
    assert len(services) >= 7
    assert len(actions) == 4
    assert [field for row in services + actions for field in missing(*row)] == []


@pytest.mark.parametrize("name", ["RobotRoom", "RobotPose"])
def test_every_field_of_a_message_about_a_robot_is_named_after_its_type(name: str) -> None:
    after = GUIDE[GUIDE.index(f"`homebot/{name}`") :].partition("\n\n")[0]
    fields = fields_of(KNOWN.find_message(f"homebot/{name}"))
    assert [field.name for field in fields if f"`{field.name}`" not in after] == []


@contextmanager
def house(folder: Path, *arguments: str) -> Iterator[Homebot]:
    """Run a homebot until its robot is known."""
    with homebot_in(folder, *arguments, until=("is running",)) as homebot:
        until(lambda: homebot.run("homebot find 'light near robot'").returncode == 0 or None, PATIENCE)
        yield homebot


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the guide's robot, after the commands that change its configuration."""
    folder = tmp_path_factory.mktemp("robot")
    for name in ("homebot.toml", "house.toml"):
        shutil.copy(ROOT / "examples" / "08_robot" / name, folder)
    (folder / "ros2_ws/src/lab/msg").mkdir(parents=True)
    (folder / "ros2_ws/src/lab/msg/Arm.msg").write_text("float64[] joints\n")
    for command in COMMANDS:
        if command.startswith(BEFORE_IT_RUNS):
            done = run(command, cwd=folder)
            assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="module")
def running(folder: Path) -> Iterator[Homebot]:
    with house(folder, "--config", "homebot.toml", "--house", "house.toml") as homebot:
        yield homebot


@pytest.mark.slow
def test_the_commands_of_the_guide_run_in_the_house_of_make_run(tmp_path: Path, folder: Path) -> None:
    assert COMMANDS[0] == 'make run ARGS="--house thesis"'
    with house(tmp_path, "--house", "thesis") as homebot:
        for command in COMMANDS[1:]:
            if not command.startswith(BEFORE_IT_RUNS):
                done = homebot.run(command)
                assert done.returncode == 0, f"{command}: {done.stdout}{done.stderr}"


def test_the_lamp_of_the_guide_is_in_the_house_of_make_run() -> None:
    (lamp,) = re.findall(r'`"target": "(\w+)"`', GUIDE)
    family = ROOT / "src/homebot/house/family/house.toml"
    assert lamp in tomllib.loads(family.read_text("utf-8"))["devices"]


@pytest.mark.slow
@pytest.mark.rooms("homeassistant")
def test_the_programs_of_the_guide_run_with_its_token(running: Homebot) -> None:
    host, _, port = running.door.rpartition(":")
    token = (running.folder / "rosie.token").read_text().split()[0]
    program = PROGRAM.replace('"127.0.0.1", 9090', f'"{host}", {port}').replace("TOKEN", token)
    done = subprocess.run(
        [sys.executable, "-c", f"{program}\nros.terminate()"], capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    seen, outcome, type_hash = done.stdout.splitlines()
    assert seen == "hall_lamp is in view"
    assert outcome == "confirmed"
    assert type_hash.startswith("RIHS01_")


@pytest.mark.slow
@pytest.mark.rooms("homeassistant")
def test_a_token_may_come_in_the_address(running: Homebot) -> None:
    token = (running.folder / "rosie.token").read_text().split()[0]
    with connect(f"ws://{running.door}/?token={token}") as client:
        client.send(json.dumps({"op": "call_service", "service": "/robots/where", "args": {"robot": "rosie"}}))
        assert json.loads(client.recv(timeout=PATIENCE))["result"] is True
