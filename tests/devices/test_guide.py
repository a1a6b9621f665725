"""What docs/devices.md says is so."""

import re
import runpy
import shlex
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pytest
from tests.guide import blocks_in

from homebot.cli.main import make_parser
from homebot.devices import Devices, handles
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.handles import CommonFilters, Handle
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import load_world
from homebot.house.devices import CoverMotor, SimulatedLamp
from homebot.testing.virtual_house import virtual_house_of

FILE = Path(__file__).parents[2] / "docs" / "devices.md"
SITE = FILE.parent / "_site" / "vocabulary.py"
PAGES = ("configuration", "protocols")
KEYS = runpy.run_path(str(SITE))["KEYS"]
FOLDER = re.compile(r"homebot\.(?:features|integrations)\.(\w+)")

_NAMED = [getattr(handles, name) for name in handles.__all__]
KINDS = sorted(
    (one for one in _NAMED if isinstance(one, type) and issubclass(one, Handle) and one is not Handle),
    key=lambda kind: kind.__name__,
)


def table(text: str, head: str) -> list[str]:
    """The rows below the table's *head*."""
    found = re.search(re.escape(head) + r"\n\|[-|]+\n((?:\|.*\n)*)", text)
    assert found is not None
    return found[1].splitlines()


def test_the_site_has_tables_of_all_types_and_capabilities() -> None:
    shown = runpy.run_path(str(SITE))["on_page_markdown"](FILE.read_text())
    types = table(shown, "| type | other words |")
    assert [row.split("`")[1] for row in types] == list(DEVICE_TYPES)
    assert "| `plug` | outlet, socket, smart plug |" in types
    capabilities = table(shown, "| capability | value | meaning |")
    assert [row.split("`")[1] for row in capabilities] == list(CAPABILITIES)
    assert "| `direction` | `forward`, `reverse` | direction of rotation |" in capabilities
    assert "| `level` | 0 to 100 % | brightness or strength; 0 only when off |" in capabilities


def test_the_site_has_a_table_of_all_handles() -> None:
    """Their device types, conditions, properties and commands."""
    shown = runpy.run_path(str(SITE))["on_page_markdown"]("<!-- table of handles -->\n")
    rows = table(shown, "| kind | device type | conditions | properties | commands |")
    assert [row.split("`")[1] for row in rows] == [kind.__name__ for kind in KINDS]
    assert "| `Siren` | `siren` | `on` | `on` | `turn_off`, `turn_on` |" in rows
    assert "<!-- table of handles -->" in FILE.read_text()
    common = ["area", "name", "tag", "reachable", "fresh", "category", "near", "within", "optional"]
    assert list(CommonFilters.__annotations__) == common
    assert all(f"`{one}`" in FILE.read_text() for one in common)


@pytest.mark.parametrize("page", PAGES)
def test_each_key_of_the_configuration_that_a_page_shows_is_one_of_a_module(page: str) -> None:
    text = FILE.with_stem(page).read_text()
    assert len(KEYS.findall(text)) == text.count("<!-- keys of") >= 3


@pytest.mark.parametrize(
    ("module", "name"),
    [
        pytest.param(module, name, marks=[pytest.mark.rooms(folder) for folder in FOLDER.findall(module)])
        for page in PAGES
        for module, name in KEYS.findall(FILE.with_stem(page).read_text())
    ],
)
def test_the_site_has_a_row_for_each_key_of_the_configuration(module: str, name: str) -> None:
    """A key without an explanation is an error of the build."""
    shown = runpy.run_path(str(SITE))["on_page_markdown"](f"<!-- keys of {module}.{name} -->\n")
    rows = table(shown, "| key | default | meaning |")
    assert {row.split("`")[1] for row in rows} == {*getattr(import_module(module), name).model_fields}


HOUSE = """
house.dialect = "homeassistant"
rooms.living_room = {}
rooms.hall = {}
devices.lamp = { kind = "lamp", room = "living_room" }
devices.other = { kind = "lamp", room = "hall" }
devices.blind = { kind = "cover", room = "living_room" }
"""


@pytest.fixture
def world(tmp_path: Path) -> World:
    (tmp_path / "house.toml").write_text(HOUSE)
    return load_world(tmp_path / "house.toml")


def install(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a module of the program that the guide shows with the app of that name."""
    (program,) = [one for one in blocks_in(FILE.read_text(), "python") if APPS[name] in one]
    module = ModuleType(name)
    exec(compile(program, name, "exec"), vars(module))  # noqa: S102  # what the guide shows
    monkeypatch.setitem(sys.modules, name, module)


APPS = {"movie_night": "class MovieNight(", "good_night": "class GoodNight("}


@pytest.mark.rooms("homeassistant")
@pytest.mark.virtual_time
async def test_the_app_that_looks_at_outcomes_turns_lamps_off(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    install("good_night", monkeypatch)
    other = world.devices["other"].device
    assert isinstance(other, SimulatedLamp)
    async with virtual_house_of("good_night:GoodNight", world=world) as house:
        await house.run_for("1m")
        await house.press("other", "on")
        await house.run_for("10s")
        assert not other.is_on
        assert house.crashed == ()


@pytest.mark.rooms("homeassistant")
@pytest.mark.virtual_time
async def test_the_app_that_it_shows_works(world: World, monkeypatch: pytest.MonkeyPatch) -> None:
    """It starts before any device is known, closes the blinds, and dims whatever lamp of the room is on or goes on."""
    install("movie_night", monkeypatch)
    lamp, other, blind = (world.devices[name].device for name in ("lamp", "other", "blind"))
    assert isinstance(lamp, SimulatedLamp)
    assert isinstance(other, SimulatedLamp)
    assert isinstance(blind, CoverMotor)
    async with virtual_house_of("movie_night:MovieNight", world=world) as house:
        await house.run_for("1m")
        assert (lamp.is_on, other.is_on, blind.position) == (False, False, 0.0)
        await house.press("lamp", "on")
        await house.press("other", "on")
        await house.run_for("10s")
        assert (lamp.brightness, other.brightness) == (0.2, 1.0)
        async with Node(house.runtime.graph, "somebody") as node:
            (handle,) = await Devices(node).find(handles.Light, name="lamp")
            await handle.turn_off()
            await house.run_for("5s")
            await handle.turn_on(level=90)
            await house.run_for("5s")
        assert lamp.brightness == 0.2
        assert house.crashed == ()


def test_the_commands_that_it_shows_are_known() -> None:
    commands = re.findall(r"^\$ homebot (.*?)\s+#", FILE.read_text(), re.MULTILINE)
    assert len(commands) == 11
    for command in commands:
        assert make_parser().parse_args(shlex.split(command)).command
