"""The live view of the simulated family house: in virtual time what is told, in a real terminal that it is shown."""

import asyncio
import fcntl
import os
import pty
import re
import select
import signal
import struct
import subprocess
import sys
import termios
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from random import Random

import anyio
import pytest
from tests.ports import reserve_port
from tests.whole_house import WHOLE_HOUSE

import homebot
from homebot.cli.house_picture import HousePicture, lines_of
from homebot.cli.live_house import LiveHouse
from homebot.config import load_config
from homebot.graph import Node
from homebot.house.description import parse_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime
from homebot.support.virtual_time import VirtualTimeLoop

pytestmark = WHOLE_HOUSE

FAMILY = Path(homebot.__file__).parent / "house" / "family"
CONFIG = load_config(FAMILY / "home.toml")
HOUSE = tomllib.loads((FAMILY / "house.toml").read_text("utf-8"))
README = (Path(__file__).parents[2] / "README.md").read_text()
PATIENCE = 120.0

DIALECTS = {"homeassistant", "homie", "plain MQTT", "shelly", "tasmota", "zigbee2mqtt"}
"""The dialects as they are shown: two of the house's eight are older and newer forms of others."""


async def watched(seconds: float) -> HousePicture:
    """Return the picture of the house after so many seconds."""
    async with MemoryBroker() as broker:
        world = parse_world(HOUSE, "house.toml")
        runtime = Runtime(
            CONFIG,
            house=world,
            robot="robot",
            with_door=False,
            services=(HostedBroker.in_memory(broker),),
            random=Random(1),  # noqa: S311 - the same run each time
        )
        async with runtime, Node(runtime.graph, "viewer") as node:
            view = LiveHouse(node, world, "title", "hint")
            await anyio.sleep(seconds)
            return view.picture()


def told(picture: HousePicture) -> list[str]:
    return [f"{one.time} {one.sign} {one.text}" for one in picture.story]


@pytest.mark.virtual_time
async def test_the_first_minute_has_every_scene_and_a_run_is_as_the_one_before() -> None:
    """Each line comes from the journal, the directory or a report: the houses's files have no such words."""
    picture = await watched(60.0)
    story = told(picture)
    text = "\n".join(story)
    for scene in (
        r"✓ hall_lamp on in \d+ ms · follow_me: hall_motion ",
        r"✓ worktop_lamp, kitchen_lamp on in \d+ ms · follow_me: kitchen_motion occupied",
        r"→ robot is in the study",
        r"! desk_lamp says on, but desk_meter measured no change: not believed",
        r"✓ study_lamp off in \d+ ms · lights_out: study_motion clear",
        r"- reading_lamp, living_lamp left on: somebody is in living: .* no door has been opened since \(pres",
        r"✗ night_lamp is gone: it has been silent for too long",
        r"☀ living_lux measures \d+ lx: living gets light",
        r"✓ kitchen_heat heating setpoint 12 °C in \d+ ms · window_heating: kitchen_window ",
    ):
        assert re.search(scene, text), (scene, text)
    assert len(picture.devices) == 25
    assert told(await watched(60.0)) == story
    readme = re.findall(r"^\d\d:\d\d \S .*$", README, re.MULTILINE)
    assert len(readme) >= 5
    for line in readme:
        words = re.escape(line[6:]).replace("\\ ", " ")
        assert re.search(re.sub(r"\d+ (ms|s ago)", r"\\d+ \1", words), text), line


@pytest.fixture(scope="module")
def picture() -> HousePicture:
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        return runner.run(watched(10.0))


@pytest.mark.parametrize(("width", "height"), [(100, 30), (80, 24), (60, 20), (20, 5)])
def test_the_picture_fits_the_terminal(picture: HousePicture, width: int, height: int) -> None:
    lines = ["".join(text for text, _ in line) for line in lines_of(picture, width, height)]
    assert len(lines) <= max(height, 8)
    assert lines[-1] == "hint"
    text = "\n".join(lines)
    if width >= 80:
        assert re.search(r"kitchen  ☺ kim", text)
        assert re.search(r"hall_lamp +on +zigbee2mqtt", text)
        assert {one for one in DIALECTS if one in text} == DIALECTS
        assert max(map(len, lines)) <= width
    assert bool(re.search(r"│ kitchen ☺+ +│ living ", text)) is (width >= 100)


@pytest.fixture
def terminal() -> Iterator[tuple[int, int]]:
    """A terminal of 100 columns and 30 lines."""
    reads, writes = pty.openpty()
    fcntl.ioctl(writes, termios.TIOCSWINSZ, struct.pack("HHHH", 30, 100, 0, 0))
    yield reads, writes
    os.close(reads)


def started(terminal: tuple[int, int], folder: Path, *arguments: str, term: str = "xterm") -> subprocess.Popen[bytes]:
    environment = {name: value for name, value in os.environ.items() if name not in {"COLUMNS", "LINES"}}
    process = subprocess.Popen(
        [sys.executable, "-m", "homebot", "run", *arguments],
        stdin=terminal[1],
        stdout=terminal[1],
        stderr=terminal[1],
        env={**environment, "TERM": term},
        cwd=folder,
        start_new_session=True,
    )
    os.close(terminal[1])
    return process


def read_until(reads: int, *words: str) -> str:
    """Return what is shown until all *words* have been, and no escapes."""
    data, until = b"", time.monotonic() + PATIENCE
    while time.monotonic() < until:
        if select.select([reads], [], [], 1.0)[0]:
            try:
                data += os.read(reads, 65_536)
            except OSError:
                break
            text = re.sub(r"\x1b\[[\d;?]*[A-Za-z]", "", data.decode(errors="replace"))
            if words and all(re.search(word, text) for word in words):
                return text
    if words:
        pytest.fail(f"{words} did not all come:\n{data.decode(errors='replace')[-3000:]}")
    return data.decode(errors="replace")


@pytest.mark.slow
def test_a_terminal_shows_the_house_and_the_line_to_try_works(terminal: tuple[int, int], tmp_path: Path) -> None:
    door = f"127.0.0.1:{reserve_port()}"
    process = started(terminal, tmp_path, "--door", door)
    text = read_until(terminal[0], r"✓ .*kitchen_lamp.* on in", f"http://{door}", "25 devices")
    assert text.startswith("homebot · a simulated house is starting …")
    why = [sys.executable, "-m", "homebot", "--door", door, "why", "kitchen_lamp"]
    assert "homebot why kitchen_lamp" in text
    assert "--door 127" not in text  # 80 columns have room for the port alone
    said = subprocess.run(why, capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert "follow_me asked kitchen_lamp for on" in said.stdout
    process.send_signal(signal.SIGINT)
    last = read_until(terminal[0])
    assert process.wait(PATIENCE) == 0
    assert "kitchen_lamp" in last.rpartition("\x1b[?1049l")[2]  # the story stays when the view is gone


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "term", "shown"),
    [
        (("--plain",), "xterm", "found kitchen_lamp on mqtt"),
        ((), "dumb", "found kitchen_lamp on mqtt"),
        (("--house", "thesis"), "xterm", "lights/roomlights405 → off"),
    ],
)
def test_elsewhere_it_is_the_log(
    terminal: tuple[int, int], tmp_path: Path, arguments: tuple[str, ...], term: str, shown: str
) -> None:
    process = started(terminal, tmp_path, "--door", "127.0.0.1:0", *arguments, term=term)
    assert "\x1b[?1049h" not in read_until(terminal[0], shown)
    process.send_signal(signal.SIGINT)
    read_until(terminal[0])
    assert process.wait(PATIENCE) == 0
