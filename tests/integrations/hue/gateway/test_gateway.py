"""The gateway to Hue bridges with a simulated bridge: pairing, kinds of devices, changes, losses and limits."""

import json
import ssl
import stat
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

import anyio
import anyio.to_thread
import pytest
from anyio.abc import TaskGroup, TaskStatus
from structlog.testing import capture_logs
from tests.gateways.watched_gateway import WatchedGateway, reading, receive, watched
from tests.integrations.homekit.gateway.fake_accessories import FakeMdns
from tests.integrations.hue.gateway.bridges import (
    BUTTONS,
    KEY,
    bridge_with_certificate,
    button,
    buttons,
    pairings_of,
    self_signed,
)
from tests.integrations.hue.simulated.bridge import HueHouseDevice, SimulatedHueBridge, make_certificate
from tests.integrations.hue.simulated.resources import radio_address
from tests.patience import PATIENCE

from homebot.devices import GatewayState, Sighting
from homebot.devices.gateway_messages import Report, SendCommandResponse
from homebot.devices.value import PlainValue
from homebot.gateways.pairing import PairResponse
from homebot.graph import Graph, Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.hue.gateway import HueGateway, HueGatewaySettings
from homebot.testing.gateway_contract.steps import KEPT

pytestmark = pytest.mark.slow


@dataclass
class House(WatchedGateway):
    """A gateway and its bridge."""

    bridge: SimulatedHueBridge
    tasks: TaskGroup
    serving: anyio.CancelScope | None = None
    gateway: HueGateway = field(init=False)
    watcher: Node = field(init=False)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        with anyio.CancelScope() as self.serving:
            await self.bridge.serve(task_status=task_status)

    async def kill(self) -> None:
        assert self.serving is not None
        self.serving.cancel()
        states = self.states()
        await receive(states, lambda one: one.state == "unavailable")

    async def install(self, kind: str, state: DeviceState, *, room: str = "", at: str = "") -> HueHouseDevice:
        info = SimulatedDeviceInfo("home", kind, f"The {kind}", "x", room)
        device = HueHouseDevice(info, lambda _: None, self.bridge, at)
        device.begin(state, has_power=True)
        await self.tasks.start(device.serve)
        return device

    async def sighting(self, name: str) -> Sighting:
        return await receive(self.sightings(), lambda one: one.name == name)

    async def send(
        self, key: str, capability: str, value: PlainValue, part: str = "light", expires: float = 0.0
    ) -> SendCommandResponse:
        return await self.command(key, part, capability, value, expires)

    async def pair(self, code: str = "") -> PairResponse:
        return await self.pair_with(self.bridge.id, code)

    async def problems(self) -> str:
        return " ".join((await self.health()).troubles)


@asynccontextmanager
async def house(folder: Path, *, paired: bool = True, act: bool = True) -> AsyncIterator[House]:
    bridge, certificate = await anyio.to_thread.run_sync(bridge_with_certificate)
    async with anyio.create_task_group() as tasks:
        home = House(bridge, tasks)
        await tasks.start(home.serve)
        table: dict[str, object] = {"pairings": folder / "pairings.json", "act": act}
        if paired:
            await anyio.to_thread.run_sync(pairings_of, bridge, certificate, folder)
        else:
            table["bridges"] = [f"{bridge.server.address}:{bridge.server.port}"]
        settings = HueGatewaySettings.model_validate(table)
        async with watched("hue", lambda node: HueGateway(node, settings)) as (home.gateway, home.watcher):
            yield home
        tasks.cancel_scope.cancel()


async def test_it_pairs_by_the_button_and_keeps_the_key_for_its_owner_alone(tmp_path: Path) -> None:
    async with house(tmp_path, paired=False) as home:
        found = await home.sighting("Hue bridge")
        assert (found.key, found.confirmed, found.authenticated) == (home.bridge.id, False, False)
        assert f"eui64:{home.bridge.id}" in found.identifiers
        assert (
            "Hue bridge: it is not paired: press its button, then run `homebot pair 'Hue bridge'`"
            in await home.problems()
        )
        assert [(one.device, one.takes_code) for one in home.gateway.unpaired()] == [(home.bridge.id, False)]
        home.bridge.press_button()
        with capture_logs() as lines:
            answer = await home.pair()
            assert (answer.success, answer.name) == (True, "Hue bridge")
            assert [*home.gateway.unpaired()] == []
            await home.install("lamp", DeviceState(text="off"))
            lamp = await home.sighting("The lamp")
            assert (await home.send(lamp.key, "on_off", True)).success
        file = tmp_path / "pairings.json"
        assert stat.S_IMODE(file.stat().st_mode) == 0o600
        (key,) = home.bridge.keys
        assert json.loads(file.read_text())[home.bridge.id]["key"] == key
        assert key not in f"{lines} {answer} {await home.problems()}"


async def test_it_says_so_if_the_button_was_not_pressed(tmp_path: Path) -> None:
    async with house(tmp_path, paired=False) as home:
        home.gateway.pressed_within = 0.2
        await home.sighting("Hue bridge")
        answer = await home.pair()
        assert (answer.success, answer.problem) == (False, "refused")
        assert "its button was not pressed" in answer.message
        assert "has no code" in (await home.pair("123")).message


async def test_an_ended_pairing_takes_its_devices_and_its_key(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        await home.install("lamp", DeviceState(text="off"))
        lamp = await home.sighting("The lamp")
        sightings = home.sightings()
        states = home.watcher.create_subscription(GatewayState, home.gateway.names.state, qos_profile=100)
        assert (await home.unpair_from(home.bridge.id)).success
        assert "was found" not in (await receive(states, lambda one: one.state == "unavailable")).reason
        await receive(sightings, lambda one: (one.key, one.kind) == (lamp.key, "removed"))
        assert json.loads((tmp_path / "pairings.json").read_text()) == {}
        assert not (await home.send(lamp.key, "on_off", True)).success


@pytest.mark.parametrize("new_one", ["self-signed", "by an authority"])
async def test_another_certificate_is_refused_with_the_next_step_and_gets_no_key(tmp_path: Path, new_one: str) -> None:
    async with house(tmp_path) as home:
        await home.sighting("Hue bridge")
        await home.kill()
        tls = home.bridge.server.tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        make = self_signed if new_one == "self-signed" else partial(make_certificate, "001788fffe123456")
        await anyio.to_thread.run_sync(make, tls)
        states = home.states()
        await home.tasks.start(home.serve)
        state = await receive(states, lambda one: "certificate" in one.reason)
        assert "press its button, then run `homebot pair 'Hue bridge'`" in state.reason
        assert home.bridge.server.peers == []


async def test_a_certificate_that_the_bridge_signed_itself_is_pinned_as_well(tmp_path: Path) -> None:
    async with house(tmp_path, paired=False) as home:
        await home.sighting("Hue bridge")
        assert home.serving is not None
        home.serving.cancel()
        home.bridge.server.tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        await anyio.to_thread.run_sync(self_signed, home.bridge.server.tls)
        await home.tasks.start(home.serve)
        home.bridge.press_button()
        assert (await home.pair()).success
        await receive(home.sightings(), lambda one: one.name == "Hue bridge" and one.confirmed)


async def test_a_bridge_that_forgot_homebot_is_named_with_the_next_step(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"))
        await home.sighting("The lamp")
        home.bridge.keys.clear()
        refused = await home.send(lamp.owner_id, "on_off", True)
        assert "has forgotten homebot: press its button" in refused.message
        await home.kill()
        states = home.states()
        await home.tasks.start(home.serve)
        state = await receive(states, lambda one: "has forgotten homebot" in one.reason)
        assert KEY not in state.reason


async def test_a_bridge_that_dns_sd_finds_is_worked_with_at_its_new_address(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        await home.sighting("Hue bridge")
        await home.kill()
        home.bridge.server.port = 0
        await home.tasks.start(home.serve)
        states = home.states()
        port, bridge_id = str(home.bridge.server.port), home.bridge.id.upper()
        mdns = FakeMdns(home.watcher.graph)
        mdns.sight("Hue Bridge", service_type="_hue._tcp", ip_address="127.0.0.1", port=port, txt_bridgeid=bridge_id)
        await receive(states, lambda one: one.state == "active")


async def test_rooms_become_areas_and_zones_tags(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"), room="Kitchen")
        light = lamp.resource_id("light")
        home.bridge.add(
            [{"id": "zone", "type": "zone", "metadata": {"name": "Downstairs"}, "children": [{"rid": light}]}]
        )
        found = await receive(home.sightings(), lambda one: any(fact.value == "Downstairs" for fact in one.metadata))
        assert (found.name, found.area, found.authenticated) == ("The lamp", "Kitchen", True)
        assert found.identifiers == (f"eui64:{radio_address(lamp.device).replace(':', '')}", f"id:hue:{found.key}")


async def test_a_scene_is_recalled(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        await home.install("lamp", DeviceState(text="off"), room="Kitchen")
        scenes = await home.sighting("Kitchen scenes")
        assert (scenes.area, [one.name for one in scenes.parts]) == ("Kitchen", ["Bright", "Dimmed"])
        assert (await home.send(scenes.key, "scene", True, scenes.parts[1].id)).success
        assert home.bridge.commands[-1] == ("scene", scenes.parts[1].id, {"recall": {"action": "active"}})
        refused = await home.send(scenes.key, "scene", False, scenes.parts[1].id)
        assert "it takes only true" in refused.message


async def test_all_lights_of_a_room_are_told_by_one_request(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"), room="Kitchen")
        lights = await home.sighting("Kitchen lights")
        assert lights.parts[0].members == (f"id:hue:{lamp.owner_id}#light",)
        assert (await home.send(lights.key, "level", 40.0, "grouped_light")).success
        body = {"on": {"on": True}, "dimming": {"brightness": 40.0}}
        assert home.bridge.commands == [("grouped_light", lights.key, body)]


async def test_the_lights_of_a_room_are_read_again(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"), room="Kitchen")
        lights = await home.sighting("Kitchen lights")
        reports = home.watcher.create_subscription(Report, home.gateway.names.readings, qos_profile=100)
        assert (await home.refresh(lights.key, "grouped_light")).success
        report = await receive(reports, lambda one: one.key == lamp.owner_id)
        assert [one.value.plain() for one in report.readings if one.capability == "on_off"] == [False]
        await home.kill()
        assert not (await home.refresh(lights.key, "grouped_light")).success


async def test_a_scene_is_recalled_without_a_lamp_that_is_gone(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"), room="Kitchen")
        scenes = await home.sighting("Kitchen scenes")
        home.bridge.remove([lamp.resource_id("light")])
        assert (await home.send(scenes.key, "scene", True, scenes.parts[1].id)).success


async def test_a_plug_is_a_plug_and_a_sensor_has_its_values(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        reports = home.reports()
        await home.install("lamp", DeviceState(text="on", is_on=True), at="plug")
        (part,) = (await home.sighting("The lamp")).parts
        assert (part.service_type, [one.name for one in part.capabilities]) == ("plug", ["on_off", "locate"])
        await home.install("motion", DeviceState(text="motion"))
        await reading(reports, "occupancy", lambda one: one is True)
        await home.install("lux", DeviceState(text="1000", value=1000.0))
        await reading(reports, "illuminance", lambda one: one == 1000.0)
        await reading(reports, "battery", lambda one: one == 90.0)
        await home.install("contact", DeviceState(text="open"))
        await reading(reports, "contact", lambda one: one is True)
        await reading(reports, "tamper", lambda one: one is False)


async def test_each_press_is_one_event_and_none_comes_from_a_list(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        home.bridge.add(buttons(button(1), button(2)))
        dimmer = await home.sighting("Dimmer")
        assert [one.id for one in dimmer.parts] == ["button-1", "button-2"]
        reports = home.reports()
        for time, event in enumerate(("initial_press", "initial_press", "repeat", "short_release", "long_release")):
            home.bridge.press("button-of-2", event, f"2026-01-01T00:00:{max(time, 1):02}.000Z")
        seen: list[tuple[str, PlainValue]] = []
        with anyio.fail_after(PATIENCE):
            while not seen or seen[-1][1] != "long_release":
                seen += [
                    (one.part, one.value.plain())
                    for one in (await reports.receive()).readings
                    if one.capability == "press"
                ]
        assert seen == [("button-2", one) for one in ("initial_press", "repeat", "single", "long_release")]


async def test_a_device_without_power_is_unreachable_and_stays(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"))
        reports = home.reports()
        await reading(reports, "reachable", lambda one: one is True)
        home.bridge.change(lamp.resource_id("zigbee_connectivity"), {"status": "connectivity_issue"})
        await reading(reports, "reachable", lambda one: one is False)
        assert (await home.send(lamp.owner_id, "on_off", True)).success  # the bridge sends it; no report proves it


async def test_after_a_gap_it_knows_what_changed_and_what_is_gone(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"))
        home.bridge.add(buttons(button(1)))
        await home.sighting("Dimmer")
        await home.kill()
        reports, sightings = home.reports(), home.sightings()
        home.bridge.change(lamp.resource_id("light"), {"on": {"on": True}})
        home.bridge.remove([BUTTONS, "button-of-1"])
        began = home.watcher.graph.clock.monotonic()
        await home.tasks.start(home.serve)
        await reading(reports, "on_off", lambda one: one is True)
        assert home.watcher.graph.clock.monotonic() - began < 5
        await receive(sightings, lambda one: (one.key, one.kind) == (BUTTONS, "removed"))


async def test_commands_around_a_restart_come_once_or_not_at_all(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"))
        await home.sighting("The lamp")
        assert (await home.send(lamp.owner_id, "level", 10.0)).success
        await home.kill()
        lost = await home.send(lamp.owner_id, "level", 20.0)
        assert (lost.success, lost.problem) == (False, "unreachable")
        states = home.states()
        await home.tasks.start(home.serve)
        await receive(states, lambda one: one.state == "active")
        assert (await home.send(lamp.owner_id, "level", 30.0)).success
        assert [body["dimming"] for _, _, body in home.bridge.commands] == [{"brightness": 10.0}, {"brightness": 30.0}]


async def test_a_busy_bridge_gets_a_command_again_until_it_expires(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"))
        await home.sighting("The lamp")
        home.bridge.busy = 2
        assert (await home.send(lamp.owner_id, "level", 10.0)).success
        home.bridge.busy = 100
        late = await home.send(lamp.owner_id, "level", 20.0, expires=0.3)
        assert (late.success, late.problem) == (False, "unreachable")
        assert [body["dimming"] for _, _, body in home.bridge.commands] == [{"brightness": 10.0}]


async def test_a_busy_bridge_is_asked_again_for_its_resources(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"))
        await home.sighting("The lamp")
        await home.kill()
        home.bridge.change(lamp.resource_id("light"), {"on": {"on": True}})
        states = home.watcher.create_subscription(GatewayState, home.gateway.names.state, qos_profile=100)
        reports = home.reports()
        home.bridge.busy = 3
        await home.tasks.start(home.serve)
        await reading(reports, "on_off", lambda one: one is True)
        assert not any("429" in one.reason for one in iter(states.take, None))


async def test_a_refusal_of_the_bridge_is_told_in_its_words(tmp_path: Path) -> None:
    async with house(tmp_path) as home:
        lamp = await home.install("lamp", DeviceState(text="off"))
        await home.sighting("The lamp")
        home.bridge.refusal = "parameter not modifiable"
        refused = await home.send(lamp.owner_id, "on_off", True)
        assert (refused.success, refused.problem) == (False, "refused")
        assert "parameter not modifiable" in refused.message


@pytest.mark.parametrize("address", ["", "192.168.1.20/api", "http://192.168.1.20", "user@192.168.1.20"])
def test_an_address_is_that_of_a_host(address: str) -> None:
    with pytest.raises(ValueError, match="bridges"):
        HueGatewaySettings(bridges=(address,))


async def test_without_a_bridge_it_waits_for_one(tmp_path: Path) -> None:
    graph = Graph()
    async with Node(graph, "hue", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
        alone = HueGateway(node, HueGatewaySettings(pairings=tmp_path / "pairings.json"))
        states = watcher.create_subscription(GatewayState, alone.names.state, qos_profile=KEPT)
        with anyio.move_on_after(0.2) as waiting:
            await alone.serve()
        assert waiting.cancelled_caught
        assert "no Hue bridge was found" in (await states.receive()).reason
