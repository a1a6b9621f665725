"""A house is described in one file, and what is wrong in it is told with its place."""

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from tests.turns import slowness

from homebot.errors import ConfigError
from homebot.house.description import load_world, parse_world
from homebot.house.family import family_names
from homebot.house.faults import Reverter, Slow, unwrap
from homebot.house.kinds import FAULTS, KINDS
from homebot.house.robot import Robot
from homebot.house.rooms import DAY

HOUSES = Path(__file__).parents[2] / "examples" / "houses"
HALL = "[rooms.hall]\ndoors = ['outside']\n"
LAMP = f"{HALL}[devices.lamp]\nkind = 'lamp'\nroom = 'hall'\n"


def test_the_family_home_is_a_house_to_test_with() -> None:
    """At least 20 devices, three people and a robot."""
    world = load_world(HOUSES / "family.toml")
    world.run_until(DAY)
    assert len(world.devices) >= 20
    assert any(isinstance(unwrap(placed.device), Robot) for placed in world.devices.values())
    assert {event.who for event in world.event_log.since(0) if event.verb == "enters"} == {"anna", "ben", "clara"}
    assert world.event_log.dropped == 0


TIMED = """
import sys, time
from pathlib import Path
from homebot.house.family import dialects
from homebot.house.description import load_world
world = load_world(Path(sys.argv[1]))
began = time.process_time()
world.run_until(86_400.0)
print(time.process_time() - began)
"""


def test_a_day_of_the_family_home_takes_under_a_third_of_a_second() -> None:
    """About 25 ms on a small machine. In a process of its own, since measuring coverage would take most of the time."""
    done = subprocess.run(
        [sys.executable, "-c", TIMED, HOUSES / "family.toml"], capture_output=True, text=True, timeout=120, check=True
    )
    assert float(done.stdout) < 0.3 * slowness()


def test_every_kind_and_every_fault_can_be_described() -> None:
    """With nothing but its name."""
    tables: dict[str, object] = {
        "rooms": {"hall": {"doors": ["outside"]}},
        "devices": {
            f"{kind}_{fault}": {"kind": kind, "room": "hall", "faults": {fault: {}}}
            for kind in KINDS
            for fault in FAULTS
        },
    }
    world = parse_world(tables, "test")
    world.run_until(3600.0)
    assert len(world.devices) == len(KINDS) * len(FAULTS)


def test_faults_are_put_on_in_the_order_of_the_file() -> None:
    """From the device outwards, with what they were told."""
    table = f"{LAMP}faults = {{ slow = {{ delay = 7.0 }}, reverter = {{}} }}\n"
    lamp = parse_world(tomllib.loads(table), "test").devices["lamp"].device
    assert isinstance(lamp, Reverter)
    assert isinstance(lamp.device, Slow)
    assert lamp.device.delay == 7.0


@pytest.mark.parametrize(
    ("text", "key", "reason"),
    [
        ("", "rooms", "is missing"),
        (f"{HALL}[house]\nsed = 1\n", "house.sed", "unknown key; did you mean seed?"),
        (
            f"[house]\ndialect = 'klingon'\n{LAMP}",
            "house.dialect",
            f"must be one of {', '.join(family_names())}, got 'klingon'",
        ),
        (
            "[rooms.hall]\n[devices.r2]\nkind = 'robot'\nroom = 'hall'\ndialect = 'homeassistant'\n",
            "devices.r2.dialect",
            "'homeassistant' has no robot, only contact",
        ),
        (
            f"{LAMP}dialect = 'klingon'\n",
            "devices.lamp.dialect",
            f"must be one of {', '.join(family_names())}, got 'klingon'",
        ),
        (f"{HALL}[house]\nlatitude = 91.0\n", "house.latitude", "less than or equal to 90"),
        (f"{HALL}window = 2.0\n", "rooms.hall.window", "less than or equal to 1"),
        ("[rooms.hall]\ndoors = ['attic']\n", "rooms.hall.doors", "there is no room 'attic'"),
        (f"{LAMP}rated_wats = 3.0\n", "devices.lamp.rated_wats", "unknown key; did you mean rated_watts or rated_lux?"),
        (f"{LAMP}brightness = 1.5\n", "devices.lamp.brightness", "less than or equal to 1"),
        (f"{LAMP}door = 'attic'\n", "devices.lamp.door", "there is no room 'attic'"),
        (f"{LAMP}faults = {{ shy = {{}} }}\n", "devices.lamp.faults.shy", "unknown key; did you mean lossy?"),
        (f"{LAMP}faults = {{ lossy = {{ share = 2.0 }} }}\n", "devices.lamp.faults.lossy.share", "less than or equal"),
        (f"{HALL}[devices.x]\nkind = 'lamb'\nroom = 'hall'\n", "devices.x.kind", "must be one of lamp, window"),
        (f"{HALL}[devices.x]\nkind = 'lamp'\n", "devices.x.room", "is missing"),
        (f"{HALL}[devices.x]\nkind = 'lamp'\nroom = 'attic'\n", "devices.x.room", "there is no room 'attic'"),
        (f"{HALL}[people.kim]\nday = [{{ at = '25:00', room = 'hall' }}]\n", "people.kim.day.0.at", "'25:00'"),
        (f"{HALL}[people.kim]\nday = [{{ at = '07:00', room = 'attic' }}]\n", "people.kim.day.0.room", "'attic'"),
        (f"{HALL}[people.kim]\nstarts_in = 'attic'\n", "people.kim.starts_in", "there is no room 'attic'"),
        (
            f"{HALL}[rooms.loft]\n[people.kim]\nday = [{{ at = '07:00', room = 'loft' }}]\n",
            "people.kim.day.0.room",
            "doors",
        ),
        (f"{LAMP}[[errands]]\nat = '07:00'\ndevice = 'lamb'\ncommand = 'on'\n", "errands.0.device", "no device 'lamb'"),
        (
            f"{LAMP}[devices.plug]\nkind = 'power_meter'\nroom = 'hall'\nof = 'lamb'\n",
            "devices.plug.of",
            "no device 'lamb'",
        ),
        (f"{HALL}[garden]\n", "garden", "unknown key; known are house, rooms, devices, people, errands"),
        ("rooms", "", "is invalid TOML"),
    ],
)
def test_a_mistake_is_named_with_file_key_and_reason(tmp_path: Path, text: str, key: str, reason: str) -> None:
    """The first of it."""
    file = tmp_path / "house.toml"
    file.write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_world(file)
    assert str(file) in str(caught.value)
    assert key in str(caught.value)
    assert reason in str(caught.value)


@pytest.mark.parametrize(
    "text", ["house = " + "[" * 5000, "[house" + ".x" * 5000 + "]", "rooms.hall.x = " + "{x=" * 5000]
)
def test_a_file_that_is_nested_too_deep_is_told_so(tmp_path: Path, text: str) -> None:
    """Whoever notices first."""
    file = tmp_path / "house.toml"
    file.write_text(text)
    with pytest.raises(ConfigError, match=r"nested too deep|is invalid TOML"):
        load_world(file)


def test_a_file_that_cannot_be_read_is_told_so(tmp_path: Path) -> None:
    """Missing, or no text."""
    with pytest.raises(ConfigError, match="does not exist"):
        load_world(tmp_path / "none.toml")
    (tmp_path / "bytes.toml").write_bytes(b"\xff\xff")
    with pytest.raises(ConfigError, match="not UTF-8"):
        load_world(tmp_path / "bytes.toml")


def test_a_kind_has_one_name_in_description_and_device() -> None:
    """Where it is carried over a wire, that is all that is known of it."""
    for kind in KINDS:
        world = parse_world({"rooms": {"hall": {}}, "devices": {"one": {"kind": kind, "room": "hall"}}}, "test")
        assert world.devices["one"].device.kind == kind
