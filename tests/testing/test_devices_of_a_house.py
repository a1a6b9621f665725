"""Tests that speak of devices: what a sensor senses, and what a device becomes, in every dialect."""

import pytest

from homebot.errors import UsageError
from homebot.house import SimulatedLamp, World
from homebot.house.description import parse_world
from homebot.house.family import dialects
from homebot.house.sensors import MotionSensor
from homebot.testing import virtual_house_of

pytestmark = pytest.mark.virtual_time

SENSED: dict[str, tuple[dict[str, bool | float], ...]] = {
    "motion": ({"occupied": True}, {"occupied": False}),
    "contact": ({"is_open": True}, {"is_open": False}),
    "lux": ({"lux": 120.0}, {"lux": 5.0}),
    "power_meter": ({"watts": 140.0}, {"watts": 0.0}),
    "thermostat": ({"temperature": 17.5}, {"temperature": 22.0}),
}
NAMELESS = {("tasmota", "motion"), ("tasmota", "contact")}
"""A switch of Tasmota does not say what it is on, so that its part is of no type with a handle."""


@pytest.mark.rooms("thesis")
@pytest.mark.parametrize("dialect", dialects())
async def test_what_a_sensor_senses_arrives_whatever_it_speaks(dialect: str) -> None:
    kinds = sorted(dialects()[dialect].kinds & SENSED.keys())
    devices = {f"hall_{kind}": {"kind": kind, "room": "hall", "dialect": dialect} for kind in kinds}
    async with virtual_house_of(world=parse_world({"rooms": {"hall": {}}, "devices": devices}, "hall.toml")) as house:
        await house.run_for("20s")
        for kind in kinds:
            for value in SENSED[kind]:
                await house.sense(f"hall_{kind}", **value)
                if (dialect, kind) not in NAMELESS:
                    await house.becomes(f"hall_{kind}", within="2s", **value)


@pytest.mark.parametrize("dialect", dialects())
async def test_a_hand_on_a_switch_arrives_whatever_it_speaks(dialect: str) -> None:
    devices = {"lamp": {"kind": "lamp", "room": "hall", "dialect": dialect}}
    async with virtual_house_of(world=parse_world({"rooms": {"hall": {}}, "devices": devices}, "hall.toml")) as house:
        await house.run_for("20s")
        for word in ("on", "off"):
            await house.press("lamp", word)
            await house.becomes("lamp", on=word == "on", within="2s")


async def test_somebody_stays_until_nobody_is_there() -> None:
    async with virtual_house_of(world=World.of(MotionSensor("motion"), SimulatedLamp("lamp"))) as house:
        await house.sense("motion", occupied=True)
        await house.press("lamp", "on")
        await house.run_for("1h")
        assert house.world.device("motion").state() == "motion"
        await house.sense("motion", occupied=False)
        assert house.world.device("motion").state() == "clear"


async def test_a_mistake_in_a_test_names_the_word() -> None:
    async with virtual_house_of(world=World.of(MotionSensor("motion"), SimulatedLamp("lamp"))) as house:
        for name, value, problem in (
            ("motion", {"occupancy": True}, "motion cannot sense occupancy=True; it senses occupied=True or False"),
            ("motion", {"occupied": 1.0}, "motion cannot sense occupied=1.0; it senses occupied=True or False"),
            ("lamp", {"on": True}, "lamp cannot sense on=True; it senses nothing"),
            ("lam", {"on": True}, "there is no device 'lam'; in the house are: motion, lamp"),
        ):
            with pytest.raises(UsageError, match=problem):
                await house.sense(name, **value)
        for name, value, problem in (
            ("lamp", {"on": True}, "lamp did not become on=True within 5m: it is on=False"),
            ("lamp", {"onn": True}, "it has no value 'onn'; did you mean on?"),
            ("lampe", {"on": True}, "there is no such device; did you mean lamp?"),
        ):
            with pytest.raises(AssertionError, match=problem.replace("?", r"\?")):
                await house.becomes(name, within="5m", **value)
        assert house.now.minute == 15


async def test_a_lamp_is_waited_for_in_the_time_of_the_house() -> None:
    async with virtual_house_of(world=World.of(SimulatedLamp("hall"))) as house:
        house.simulated.press("hall", "on")
        await house.becomes("hall", on=True)
        assert house.now.minute == 0
