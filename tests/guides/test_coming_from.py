"""The guide for users of other programs: its rules of homebot do in virtual time as it says."""

from __future__ import annotations

import ast
import re
from collections.abc import Awaitable, Callable
from importlib import import_module
from pathlib import Path
from typing import cast

import pytest

from homebot.clock import read_zone
from homebot.house import World
from homebot.house.description import load_world
from homebot.testing import VirtualHouse, virtual_house_of

GUIDE = (Path(__file__).parents[2] / "docs" / "coming-from.md").read_text("utf-8")
SHOWN = re.findall(r"(?:<!-- (.*?) -->\n)?```python\n(.*?)```", GUIDE, re.DOTALL)
FILES = {what.removeprefix("file: "): text for what, text in SHOWN if what.startswith("file: ")}
(TEST,) = (text for what, text in SHOWN if what == "test")
TEST_NAME = TEST.partition("async def ")[2].partition("(")[0]
HOUSE = """
[house]
dialect = "zigbee2mqtt"
[rooms.hall]
[devices]
hall_lamp = { kind = "lamp", room = "hall" }
hall_motion = { kind = "motion", room = "hall" }
hall_heater = { kind = "thermostat", room = "hall" }
hall_power = { kind = "power_meter", room = "hall", of = "hall_lamp" }
"""


@pytest.fixture
def world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> World:
    """Write the programs of the guide where they are found, and return their house."""
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in FILES:
        import_module(name.removesuffix(".py"))
    (tmp_path / "house.toml").write_text(HOUSE)
    read_zone("Europe/Berlin")  # from the disk, once
    return load_world(tmp_path / "house.toml")


@pytest.mark.virtual_time
async def test_the_test_of_the_guide_passes(world: World) -> None:
    """It is about the light by motion."""
    shown: dict[str, object] = {}
    exec(TEST, shown)  # noqa: S102 - our own guide
    test = cast("Callable[[VirtualHouse], Awaitable[None]]", shown[TEST_NAME])
    (mark,) = cast("list[pytest.Mark]", vars(test)["pytestmark"])
    assert mark.kwargs["world"] == "house.toml"
    async with virtual_house_of(*mark.args, world=world, config=mark.kwargs["config"]) as house:
        await test(house)


@pytest.mark.virtual_time
async def test_the_heating_follows_presence(world: World) -> None:
    async with virtual_house_of("presence_heating:PresenceHeating", world=world) as house:
        await house.sense("hall_motion", occupied=True)
        await house.becomes("hall_heater", heating_setpoint=21, within="5s")
        await house.sense("hall_motion", occupied=False)
        await house.becomes("hall_heater", heating_setpoint=17, within="32m")


@pytest.mark.virtual_time
async def test_the_report_has_the_energy_that_the_meter_counted(world: World) -> None:
    """A lamp of 9 W for two hours."""
    virtual = virtual_house_of(
        "energy_report:EnergyReport", world=world, start="2026-01-01 18:00", config={"history": {"enabled": True}}
    )
    async with virtual as house:
        await house.press("hall_lamp", "on")
        await house.run_until("20:01")
        assert [one.text for one in house.notifications] == ["Energy: hall_power: 0.02 kWh"]


def test_each_program_of_homebot_has_thirty_lines_at_most() -> None:
    """The others are shown to be read, and are Python at least."""
    assert len(FILES) == 3
    assert max(text.count("\n") for text in FILES.values()) <= 30
    for _, text in SHOWN:
        compile(text, "guide", "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
