"""The guide for users of other programs: its rules of homebot do in virtual time as it says."""

import ast
import re
import sys
from collections.abc import Awaitable, Callable
from importlib import import_module
from pathlib import Path
from typing import cast

import pytest
from tests.guide import blocks_in, guide

from homebot.clock import read_zone
from homebot.house import World
from homebot.house.description import load_world
from homebot.testing import VirtualHouse, virtual_house_of

GUIDE = guide("coming-from")
SHOWN = re.findall(r"(?:<!-- (.*?) -->\n)?```python\n(.*?)```", GUIDE, re.DOTALL)
FILES = {what.removeprefix("file: "): text for what, text in SHOWN if what.startswith("file: ")}
(TEST,) = (text for what, text in SHOWN if what == "test")
TESTS = re.findall(r"async def (\w+)", TEST)
(HOUSE,) = blocks_in(GUIDE, "toml")


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> World:
    """Write the programs of the guide where they are found, and return their house."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in FILES:
        monkeypatch.delitem(sys.modules, name.removesuffix(".py"), raising=False)  # another test's program
        import_module(name.removesuffix(".py"))
    (tmp_path / "house.toml").write_text(HOUSE)
    read_zone("Europe/Berlin")  # from the disk, once
    return load_world(tmp_path / "house.toml")


@pytest.mark.rooms("zigbee2mqtt", "history")
@pytest.mark.virtual_time
@pytest.mark.parametrize("name", TESTS)
async def test_the_tests_of_the_guide_pass(world: World, name: str) -> None:
    shown: dict[str, object] = {}
    exec(TEST, shown)  # noqa: S102 - our own guide
    test = cast("Callable[[VirtualHouse], Awaitable[None]]", shown[name])
    (mark,) = cast("list[pytest.Mark]", vars(test)["pytestmark"])
    assert mark.kwargs["world"] == "house.toml"
    async with virtual_house_of(*mark.args, world=world, config=mark.kwargs.get("config", {})) as house:
        await test(house)


@pytest.fixture
def two_rooms(tmp_path: Path) -> World:
    """Return the house of the guide with a second motion sensor."""
    study = '[rooms.study]\n[devices.study_motion]\nkind = "motion"\nroom = "study"\n'
    (tmp_path / "house.toml").write_text(HOUSE + study)
    return load_world(tmp_path / "house.toml")


@pytest.mark.rooms("zigbee2mqtt")
@pytest.mark.usefixtures("world")
@pytest.mark.virtual_time
async def test_the_heating_goes_by_the_last_motion_of_all_sensors(two_rooms: World) -> None:
    """As the group of the others does: a sensor that has been clear for long does not count alone."""
    async with virtual_house_of("presence_heating:PresenceHeating", world=two_rooms) as house:
        await house.sense("study_motion", occupied=True)
        await house.becomes("hall_heater", heating_setpoint=21, within="5s")
        await house.run_for("29m")
        await house.sense("study_motion", occupied=False)
        await house.run_for("29m")
        await house.becomes("hall_heater", heating_setpoint=21)
        await house.becomes("hall_heater", heating_setpoint=17, within="2m")


def test_each_program_of_homebot_has_thirty_lines_at_most() -> None:
    """The others are shown to be read, and are Python at least."""
    assert len(FILES) == len(TESTS) == 4
    assert max(text.count("\n") for text in FILES.values()) <= 30
    for _, text in SHOWN:
        compile(text, "guide", "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
