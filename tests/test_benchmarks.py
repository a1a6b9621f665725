"""The benchmarks still run; how fast is no test's business."""

import json
import os
import re
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest
from tests.sizes import NIGHTLY, nightly

pytestmark = pytest.mark.slow

PROGRAM = Path(__file__).parent.parent / "benchmarks/run.py"
SOURCE = Path(__file__).parent.parent / "src/homebot"
BENCHMARKS = Path(__file__).parent.parent / "docs/benchmarks.md"
PAGE = Path(__file__).parent.parent / "docs/how-a-message-travels.md"


def run(name: str, patience: float = 120) -> str:
    """What the benchmark prints where Home Assistant is not installed."""
    command = [sys.executable, str(PROGRAM), "--quick", "--home-assistant", "/no/such/python", name]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=patience)
    assert "failed, with the error above" not in done.stderr, done.stderr
    return done.stdout


def test_a_benchmark_runs_and_says_which_peer_is_missing() -> None:
    """Also without Home Assistant, which takes minutes to install."""
    printed = run("service_calls")

    assert "Services: calls per second" in printed
    assert "Home Assistant is not measured: no /no/such/python" in printed


@pytest.mark.parametrize(
    ("body", "code", "said"),
    [
        ("return Report('T', (), (), [('goal', ''), ('Room 0 lit', verdict(True))])", 0, ""),
        ("return Report('T', (), (), [('goal', ''), ('Room 0 lit', verdict(False))])", 1, "FALLS SHORT: places\n"),
        ("return Report('T', (), [f'Aim: {verdict(False)}'])", 1, "FALLS SHORT: places\n"),
        ("raise MissingPeerError('no planner')", 1, "not measured, at least in part: places\n"),
        ("return Report('T', (), missing=['models'])", 1, "not measured, at least in part: places\n"),
    ],
)
@pytest.mark.parametrize("extras", [[], ["--extras", sys.executable]])
def test_a_benchmark_that_falls_short_or_lacks_a_peer_is_not_green(
    body: str, code: int, said: str, extras: list[str], tmp_path: Path
) -> None:
    """Nor where another Python runs it."""
    copied = shutil.copytree(PROGRAM.parent, tmp_path / "benchmarks")
    head = "from report import MissingPeerError, Report, verdict\n\ndef run(plan):\n    "
    name = "machines" if extras else "places"
    (copied / f"{name}.py").write_text(head + body + "\n")
    command = [sys.executable, str(copied / "run.py"), "--quick", "--home-assistant", "/no", *extras, name]

    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)

    assert done.returncode == code
    assert done.stderr.endswith(said.replace("places", name))
    assert ("NOT MEASURED" in done.stdout) is ("not measured" in said)


def test_a_failing_benchmark_does_not_stop_the_next(tmp_path: Path) -> None:
    """The program ends with an error that names it."""
    copied = shutil.copytree(PROGRAM.parent, tmp_path / "benchmarks")
    (copied / "places.py").write_text("def run(plan):\n    raise RuntimeError('no more')\n")
    command = [sys.executable, str(copied / "run.py"), "--quick", "--home-assistant", "/no", "places", "service_calls"]

    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)

    assert "Services: calls per second" in done.stdout
    assert "RuntimeError: no more" in done.stderr
    assert done.stderr.endswith("failed, with the error above: places\n")
    assert done.returncode == 1


@nightly
@pytest.mark.parametrize("name", re.findall(r'^    "(\w+)",$', PROGRAM.read_text(), re.MULTILINE))
def test_every_benchmark_runs(name: str) -> None:
    assert re.search(r"^## ", run(name, patience=900), re.MULTILINE)


def test_the_room_of_a_position_is_found_in_each_size_of_house() -> None:
    rooms = re.findall(r"^\| (\d+) +\| [\d.]+ µs", run("places"), re.MULTILINE)

    assert rooms == ["12", "100", "1000"]


def test_what_is_near_is_asked_in_each_size_of_house() -> None:
    """By its kind, by a distance, and by the name of one."""
    rooms = re.findall(r"^\| (\d+) +\| \d+ +\| .+? +\| [\d.]+ ms", run("near"), re.MULTILINE)

    assert rooms == [size for size in ("12", "100", "1000") for _ in range(3)]


@pytest.mark.parametrize(
    ("house", "library"),
    [
        ("mqtt, Home Assistant discovery", "homebot"),
        ("homeassistant, device", "aiohttp"),
        ("homekit, lamp and its bridge", "pyhap"),
        ("hue, lamp of a bridge", "trustme"),
    ],
)
@pytest.mark.rooms("homeassistant", "homekit", "hue", "thesis")
def test_the_worker_of_discovery_tells_when_devices_were_found_and_missed(
    house: str, library: str, tmp_path: Path
) -> None:
    """Which paired bridges have their keys in temporary files."""
    pytest.importorskip(library)
    command = [sys.executable, str(PROGRAM.with_name("discovery_worker.py")), house, "2", "10"]
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120, env=environment)
    assert done.returncode == 0, done.stderr
    joined, died = (json.loads(line) for line in done.stdout.splitlines())
    assert len(joined["times"]) == 2
    assert joined["memory"] > 0
    assert [how for _, how in died["noticed"]] == ["unreachable"] * 2


def test_the_page_has_a_row_for_each_house_of_discovery() -> None:
    houses = re.findall(r'"(\w+, .+?)": HouseSpec', PROGRAM.with_name("discovery_houses.py").read_text())
    table = BENCHMARKS.read_text().partition("\n## Discovery\n")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| (\w.*?) \|", table, re.MULTILINE)[1:]

    assert [letters(row) for row in rows] == [letters(house) for house in houses]


def letters(name: str) -> str:
    """The letters of a name, without case."""
    return "".join(filter(str.isalpha, name.lower()))


@cache
def walks() -> dict[str, tuple[int, dict[str, int]]]:
    """Calls of each walk, as the table has them, and calls by file, as the lists below it have them."""
    printed = run("walks")
    table = re.findall(r"^\| (.+?) +\| (\d+) +\| <= \d+ +\| (\d+) ", printed, re.MULTILINE)
    listed = {
        name: {file: int(count) for file, count in re.findall(r"(\S+\.py) (\d+)", files)}
        for name, files in re.findall(r"^(.+?): (\S+\.py \d+.*)$", printed, re.MULTILINE)
    }
    assert {name: int(files) for name, _, files in table} == {name: len(files) for name, files in listed.items()}
    return {name: (int(calls), listed[name]) for name, calls, _ in table}


@pytest.mark.rooms("homeassistant", "homekit", "hue", "thesis")
def test_walks_counts_every_call_of_every_walk_and_the_same_each_time() -> None:
    """Calls of homebot's own functions, from the client to the client; the broker's are none of them."""
    first = walks()

    assert [name.partition(" ")[0] for name in first] == ["text", "announcement", "JSON", "find(Light,", "turn_on"]
    assert all(calls == sum(files.values()) > 0 for calls, files in first.values())
    named = {file for _, files in first.values() for file in files}
    assert all((SOURCE / file).is_file() for file in named)
    assert not [file for file in named if file.startswith(("mqtt/broker/", "testing/"))]
    assert not NIGHTLY or first == walks.__wrapped__()


MOST = {"text": (158, 52), "announcement": (301, 72), "JSON": (92, 34), "find": (65, 15), "turn_on": (186, 57)}
"""The calls and files of each walk at most."""


@pytest.mark.rooms("homeassistant", "homekit", "hue", "thesis")
def test_no_walk_takes_more_calls_and_files_than_before() -> None:
    """The counts of Python 3.11, with room for a few; a new Python may count fewer."""
    for walk, (calls, files) in MOST.items():
        (walked,) = (counted for name, counted in walks().items() if name.startswith(walk))
        assert walked[0] <= calls, walk
        assert len(walked[1]) <= files, walk


SECTIONS = {
    "A text message": ("text message of a known device", 7),
    "A JSON state": ("JSON state", 7),
    "A command": ("turn_on", 10),
}
"""The walk of each section of the page, and the number of its steps."""


@pytest.mark.rooms("homeassistant", "homekit", "hue", "thesis")
def test_the_files_that_a_message_is_said_to_pass_are_on_its_walk() -> None:
    """A page for newcomers that names what is called no more would lead them astray."""
    for section, (walk, count) in SECTIONS.items():
        table = PAGE.read_text().partition(f"\n## {section}\n")[2].partition("\n## ")[0]
        steps = re.findall(r"^\| \d+ \| \[`(\S+)`\]", table, re.MULTILINE)

        (passed,) = (files for name, (_, files) in walks().items() if name.startswith(walk))

        assert len(steps) == count
        assert [file for file in steps if file not in passed] == []
