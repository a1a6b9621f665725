"""A reload: all of the configuration is checked, then rights, policies and places are swapped, or nothing is."""

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass

import pytest
from structlog.testing import capture_logs
from tests.apps.houses import flat, lamp, motion

from homebot import Devices, Light, Refused
from homebot.config import parse_config
from homebot.devices.client_rights import NodeGrants
from homebot.devices.health import GetHealth
from homebot.graph import Node
from homebot.messages.std_srvs import Trigger, TriggerRequest
from homebot.runtime.plan import make_plan
from homebot.runtime.reload import RunningParts, keys_for_restart, reload_configuration
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = pytest.mark.virtual_time

NEVER_OFF = {"quiet_hours": [{"start": "00:00", "end": "23:59", "commands": ["turn off light"]}]}
GUARD = {"presence_guard": True}


@dataclass
class Home:
    house: VirtualHouse
    node: Node

    async def reload(self, tables: Mapping[str, object], *, may_lose: bool = False) -> str:
        """Return the line of the log."""
        before = self.house.runtime.config
        new = {**before.model_dump(), **tables}
        with capture_logs() as lines:
            await self.house.runtime.reload(lambda: parse_config(new, "homebot.toml"), may_lose=may_lose)
        await self.house.run_for("1s")  # the change comes to those who follow
        (line,) = [one["message"] for one in lines if one["event"] == "runtime.reloaded"]
        return str(line)

    async def turn_off(self) -> object:
        (light,) = await Devices(self.node).find(Light)
        await light.turn_on()
        return await light.turn_off()

    async def rooms(self) -> dict[str, str]:
        return {one.device.id: one.device.area for one in await Devices(self.node).find(Light)}


@asynccontextmanager
async def home(**tables: object) -> AsyncIterator[Home]:
    world = flat(hall_lamp=lamp("hall"), hall_motion=motion("hall"))
    async with virtual_house_of(world=world, config=tables) as house, Node(house.runtime.graph, "app") as node:
        await house.run_for("1m")
        yield Home(house, node)


async def troubles(here: Home) -> tuple[str, ...]:
    return (await here.node.create_client(GetHealth, "/control/health").call(GetHealth.Request())).troubles


@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize("first", [{}, {"presence_guard": {"doors": {"atic": ["hatch"]}}}])
async def test_misspelt_names_are_those_of_the_newest_configuration(first: dict[str, object]) -> None:
    async with home(control=first) as here:
        await here.house.run_for("10m")
        await here.reload({"control": {"witnesses": {"light": "hall_moton"}}}, may_lose=True)
        await here.house.run_for("5m")
        (problem,) = await troubles(here)
        assert problem.startswith(
            "control.witnesses.'light': there is no device 'hall_moton'; did you mean hall_motion"
        )
        await here.reload({"control": {}})
        assert await troubles(here) == ()


@pytest.mark.rooms("homeassistant")
async def test_policies_take_effect_and_go_again() -> None:
    async with home() as here:
        assert (await here.turn_off()).succeeded  # type: ignore[attr-defined]
        assert await here.reload({"control": NEVER_OFF}) == "tokens, rights, policies and places were reloaded"
        refused = await here.turn_off()
        assert isinstance(refused, Refused)
        assert refused.policy == "quiet_hours"
        assert (await here.reload({"control": {}})).startswith("nothing was reloaded: homebot.toml lacks what it had")
        assert isinstance(await here.turn_off(), Refused)
        await here.reload({"control": {}}, may_lose=True)
        assert (await here.turn_off()).succeeded  # type: ignore[attr-defined]


@pytest.mark.rooms("homeassistant")
async def test_a_policy_that_needs_sensors_finds_them() -> None:
    """The motion sensor has never detected anybody, so that its silence proves nothing."""
    async with home() as here:
        assert (await here.turn_off()).succeeded  # type: ignore[attr-defined]
        await here.reload({"control": GUARD})
        await here.house.run_for("1s")
        refused = await here.turn_off()
        assert isinstance(refused, Refused)
        assert "hall_motion" in refused.reason


@pytest.mark.rooms("homeassistant")
@pytest.mark.rooms("alerts")
async def test_notifications_go_where_the_newest_configuration_says() -> None:
    async with home() as here:
        test = here.node.create_client(Trigger, "/alerts/test")
        assert "[notify] has none" in (await test.call(TriggerRequest())).message
        await here.reload({"notify": {"topic": "people"}})
        assert (await test.call(TriggerRequest())).success
        assert "reach you" in json.loads(await here.house.hears("people"))["message"]
        await here.reload({"notify": {"topic": "others"}})
        assert (await test.call(TriggerRequest())).success
        assert "reach you" in json.loads(await here.house.hears("others"))["message"]
        await here.reload({"notify": None}, may_lose=True)
        assert not (await test.call(TriggerRequest())).success


@pytest.mark.rooms("homeassistant")
async def test_the_rights_of_an_app_are_swapped() -> None:
    async with home() as here:
        await here.reload({"apps": {"app": {"class": "light_service", "act": "light in kitchen"}}})
        assert isinstance(await here.turn_off(), Refused)
        await here.reload({"apps": {"app": {"class": "light_service", "act": "light in hall"}}})
        assert (await here.turn_off()).succeeded  # type: ignore[attr-defined]


async def test_a_reload_that_fails_leaves_the_rights_of_all_apps_as_they_were() -> None:
    """An app without a row may command everything, so half a list is none."""

    def fail(_: NodeGrants) -> NodeGrants:
        raise ZeroDivisionError

    first, second = (
        parse_config({"apps": {"one": {"class": "light_service", "act": query}}}, "homebot.toml")
        for query in ("light in hall", "plug")
    )
    plan = make_plan(first)
    held, parts = plan.grants, RunningParts(lambda: None, None, None, fail)
    with pytest.raises(ZeroDivisionError):
        await reload_configuration(first, plan, parts, lambda: second, make_plan, may_lose=True)
    assert held.now == make_plan(first).grants.now
    done, _ = await reload_configuration(
        first,
        plan,
        RunningParts(lambda: None, None, None, lambda grants: grants),
        lambda: second,
        make_plan,
        may_lose=True,
    )
    assert done.grants is held
    assert held.now.scopes == {"/one": ("act: plug",)}


@pytest.mark.rooms("homeassistant")
async def test_places_are_swapped_and_devices_described_anew() -> None:
    async with home() as here:
        before = dict(here.house.runtime.config.places)
        devices = {**before["devices"], "hall_lamp": {"room": "Attic"}}  # type: ignore[dict-item]
        line = await here.reload({"places": {"devices": devices, "rooms": {"hall": {}, "Attic": {}}}})
        assert line == "tokens, rights, policies and places were reloaded"
        assert await here.rooms() == {"hall_lamp": "Attic"}
        await here.reload({"places": before})
        assert await here.rooms() == {"hall_lamp": "hall"}


@pytest.mark.rooms("homeassistant")
@pytest.mark.parametrize(
    ("tables", "mistake"),
    [
        ({"history": {"kep": 1}}, "homebot.toml: history.kep: unknown key"),
        ({"places": {"rooms": {"a": {"doors": ["nowhere"]}}}}, "homebot.toml: places.rooms.a.doors"),
    ],
)
@pytest.mark.rooms("history")
async def test_a_mistake_anywhere_changes_nothing(tables: dict[str, object], mistake: str) -> None:
    async with home() as here:
        line = await here.reload({"control": NEVER_OFF, **tables})
        assert line.startswith(f"nothing was reloaded: {mistake}")
        assert (await here.turn_off()).succeeded  # type: ignore[attr-defined]


@pytest.mark.rooms("history")
def test_the_keys_that_wait_for_a_restart_are_named_each() -> None:
    before = {
        "home": {"name": "a"},
        "gateways": {"mqtt": {"url": "mqtt://a", "act": True}, "ble": {}},
        "apps": {"one": {"act": "light", "rooms": ["a"]}},
        "robots": {"rosie": {}},
        "door": {"port": 1, "token": "x"},
        "control": {"timeout": 3.0, "approvals": True},
    }
    after = {
        "home": {"name": "b"},
        "gateways": {"mqtt": {"url": "mqtt://b", "act": True}, "nfc": {}},
        "apps": {"one": {"act": "lock", "rooms": ["b"]}},
        "robots": {"rosie": {}},
        "door": {
            "port": 1,
            "token": "y",
            "scope": ["read"],
            "tokens": {"a": {"token": "z", "scope": ["read", "robot: rosie", "robot: gina"]}},
        },
        "control": {"timeout": 4.0, "approvals": False},
        "history": {"keep": {}},
        "places": {"rooms": {"Hall": {}}},
    }
    found = keys_for_restart(parse_config(before, "a"), parse_config(after, "b"))
    named = "home.name gateways.mqtt.url gateways.ble gateways.nfc apps.one.rooms control.timeout history.keep"
    assert found == (*named.split(), "door.tokens (the robot gina)")
    assert keys_for_restart(parse_config(after, "a"), parse_config(after, "b")) == ()
