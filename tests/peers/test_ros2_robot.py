"""The robot of 40 lines on pyzeros, in a process of its own, at a homebot that runs."""

import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from tests.ports import reserve_port
from tests.shell import Homebot, homebot_in, run

ROOT = Path(__file__).parents[2]
ROBOT = ROOT / "examples" / "10_ros2_robot"
EYE = Path(__file__).with_name("ros2_eye.py")
ALL = ("read", "act: harmless", "robot: rosie")


@contextmanager
def house(folder: Path, *scopes: str) -> Iterator[Homebot]:
    """A house in *folder*, in which the robot's token has *scopes*."""
    shutil.copytree(ROBOT, folder, dirs_exist_ok=True)
    port = str(reserve_port())
    rights = " ".join(f"--scope {shlex.quote(one)}" for one in scopes)
    assert run(f"homebot token new rosie {rights}", cwd=folder).returncode == 0
    token = (folder / "rosie.token").read_text().strip()
    for name in ("homebot.toml", "robot.json5"):
        text = (folder / name).read_text()
        text = text.replace("7447", port).replace("TOKEN", token)
        (folder / name).write_text(text.replace('"/devices/command"', '"/devices/command", "/devices/identify"'))
    rooms = str(ROOT / "examples" / "08_robot" / "house.toml")
    until = ("found hall_lamp", "found kitchen_lamp", "the robot is in hall")
    with homebot_in(folder, "--config", "homebot.toml", "--house", rooms, until=until) as homebot:
        yield homebot


def robot_at(homebot: Homebot, *program: str) -> subprocess.CompletedProcess[str]:
    """Run the robot, or a *program*, to its end. pyzeros compiles its messages at first, which takes a minute."""
    pytest.importorskip("pyzeros")
    program = (sys.executable, *(program or ("ros2_robot.py",)))
    environment = os.environ | {"CYDR_CACHE_DIR": str(ROOT / ".cydr_cache")}
    return subprocess.run(program, cwd=homebot.folder, env=environment, capture_output=True, text=True, check=False)


def test_it_turns_on_the_nearest_lamp_and_hears_the_outcome(tmp_path: Path) -> None:
    assert len((ROBOT / "ros2_robot.py").read_text().splitlines()) <= 40
    with house(tmp_path, *ALL) as homebot:
        assert robot_at(homebot).stdout == "hall_lamp is on: confirmed\n"
        assert "the client rosie asked for on" in homebot.run("homebot why hall_lamp").stdout


def test_without_the_right_to_act_it_hears_what_is_missing(tmp_path: Path) -> None:
    with house(tmp_path, "read", "robot: rosie") as homebot:
        assert robot_at(homebot).stdout.startswith("the right act is missing; the token rosie has: read, robot: rosie.")
        assert homebot.run("homebot journal").stdout == "the journal is empty\n"


def test_without_the_token_it_can_do_nothing(tmp_path: Path) -> None:
    with house(tmp_path, *ALL) as homebot:
        login = tmp_path / "robot.json5"
        login.write_text(login.read_text().replace('password: "', 'password: "not '))
        assert robot_at(homebot).returncode == 1
        assert homebot.run("homebot journal").stdout == "the journal is empty\n"
        found = homebot.run("homebot find 'light near rosie'")
        assert found.stderr == "homebot: the position of rosie is not known yet\n"


@pytest.mark.parametrize(
    ("candidates", "answer"),
    [("light", "hall_lamp is in view"), ("kitchen_lamp", "kitchen_lamp is not in view")],
)
def test_its_light_sensor_tells_which_lamp_it_sees(tmp_path: Path, candidates: str, answer: str) -> None:
    with house(tmp_path, *ALL) as homebot:
        seen = robot_at(homebot, str(EYE), candidates)
        assert seen.stdout.startswith(answer), seen.stderr
