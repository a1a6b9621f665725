"""Devices are commissioned and removed through the gateway, and no setup code is kept, shown or logged."""

import json
import logging
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from aiohttp import web
from tests.gateways.http_servers import serving
from tests.gateways.watched_gateway import reading
from tests.integrations.matter.gateway.test_gateway import House, gateway_to, house
from tests.integrations.matter.simulated.node import ServedMatterNode
from tests.patience import PATIENCE

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Command, Report, SendCommand
from homebot.devices.names import PairingNames
from homebot.devices.value import Value
from homebot.errors import TypeMismatchError
from homebot.gateways.pairing import (
    ListUnpaired,
    Pair,
    PairRequest,
    PairResponse,
    Unpair,
    UnpairedRequest,
    UnpairRequest,
)
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.matter.gateway.gateway import (
    Commission,
    CommissioningNames,
    CommissionRequest,
    Decommission,
    DecommissionRequest,
)
from homebot.messages.json import message_from_json
from homebot.testing.gateway_contract.steps import KEPT

CODE = "MT:Y.K90AFN00KA0648G00"
"""Of the discriminator 3840 and the passcode 20202021, the default of example devices."""

DIGITS = "34970112332"
NAMES = CommissioningNames("matter")
FRAMES = json.loads((Path(__file__).parent / "recorded_frames.json").read_text("utf-8"))
PLACE = f"id:matter:deviceid_{FRAMES['greeting']['compressed_fabric_id']:016X}-{2:016X}-MatterNodeDevice"
"""Frames of python-matter-server 8.1.2 about a light with a button on matter.js 0.17.9, as they were received."""


async def commission(node: Node, code: str, *, network_only: bool = True) -> PairResponse:
    client = node.create_client(Commission, NAMES.commission)
    return await client.call(CommissionRequest(code=code, network_only=network_only), timeout=PATIENCE)


async def decommission(node: Node, key: str) -> PairResponse:
    return await node.create_client(Decommission, NAMES.decommission).call(
        DecommissionRequest(key=key), timeout=PATIENCE
    )


async def new_lamp(home: House, code: str) -> ServedMatterNode:
    """A lamp that has power and waits for its code."""
    info = SimulatedDeviceInfo("home", "lamp", "New lamp", "lights", "hall")
    lamp = ServedMatterNode(info, home.orders.append, home.server, setup_code=code)
    lamp.begin(DeviceState(text="off"), has_power=True)
    await home.tasks.start(lamp.serve)
    return lamp


@pytest.mark.parametrize("code", [CODE, DIGITS, "3497-011-2332"])
async def test_a_device_joins_by_its_code_and_leaves(code: str, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.DEBUG)
    async with house() as home:
        await new_lamp(home, code)
        sightings, reports = home.sightings(), home.reports()
        joined = await commission(home.watcher, code)
        assert (joined.success, joined.message, joined.name) == (True, "", "New lamp")
        assert home.server.calls[-1] == ("commission_with_code", {"code": code, "network_only": True})
        assert (await home.send(joined.key, "on_off", True)).success
        assert home.orders == ["on"]
        await reading(reports, "reachable", lambda one: one is True)
        left = await decommission(home.watcher, joined.key)
        assert (left.success, left.key) == (True, joined.key)
        kinds = [one.kind for one in iter(sightings.take, None)]
        assert kinds[-1] == "removed"
        again = await commission(home.watcher, code)
        assert (again.success, again.key) == (True, "node-2")
        assert code not in repr(home.gateway.__dict__)
    assert code not in caplog.text


async def test_the_page_pairs_any_device_that_has_a_code() -> None:
    """It asks each gateway for the devices that wait."""
    names = PairingNames("matter")
    async with house() as home:
        await new_lamp(home, DIGITS)
        pair = home.watcher.create_client(Pair, names.pair)
        waiting = await home.watcher.create_client(ListUnpaired, names.unpaired).call(UnpairedRequest())
        assert [(one.device, one.name, one.takes_code, one.problem) for one in waiting.devices] == [
            ("", "Matter", True, "")
        ]
        assert "11 or 21 digits" in (await pair.call(PairRequest(device="", code=""))).message
        joined = await pair.call(PairRequest(device="", code=DIGITS), timeout=PATIENCE)
        assert (joined.success, joined.name) == (True, "New lamp")
        assert "commissioned already" in (await pair.call(PairRequest(device="node-1", code=DIGITS))).message
        unpair = home.watcher.create_client(Unpair, names.unpair)
        left = await unpair.call(UnpairRequest(device="node-1"), timeout=PATIENCE)
        assert (left.success, left.name, home.server.nodes) == (True, "New lamp", {})


@pytest.mark.parametrize(
    ("code", "reason"),
    [
        ("1234", "11 or 21 digits"),
        ("MT:Y.K90AFN00", "bytes instead of 11"),
        ("MT:Y.K90AFN00KA0648$$$", "base 38"),
        ("MT:ZZZZZZZZZZZZZZZZZZZ", "base 38"),
        (DIGITS, "pairing mode"),
    ],
)
async def test_a_code_that_commissions_nothing_is_refused_without_showing_it(
    code: str, reason: str, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.DEBUG)
    async with house() as home:
        response = await commission(home.watcher, code)
    assert (response.success, response.problem) == (False, "refused")
    assert reason in response.message
    assert code not in response.message + caplog.text


def test_no_text_about_a_request_shows_its_code() -> None:
    request = CommissionRequest(code=CODE)
    assert CODE not in f"{request} {request!r}"
    with pytest.raises(TypeMismatchError) as caught:
        message_from_json(CommissionRequest, {"code": CODE * 20})
    assert CODE not in str(caught.value)


async def test_without_bluetooth_the_network_is_all_there_is() -> None:
    async with house() as home:
        response = await commission(home.watcher, CODE, network_only=False)
    assert (response.problem, "no Bluetooth" in response.message) == ("refused", True)


async def test_a_gateway_that_only_observes_commissions_nothing() -> None:
    async with house(act=False) as home:
        await new_lamp(home, CODE)
        response = await commission(home.watcher, CODE)
        assert (response.problem, "only observes" in response.message) == ("refused", True)
        assert home.server.nodes == {}
        await home.commission("lamp", DeviceState(text="off"))
        assert (await decommission(home.watcher, "node-1")).problem == "refused"
        assert 1 in home.server.nodes


async def test_a_device_more_than_allowed_is_commissioned_and_the_answer_says_so() -> None:
    async with house(max_nodes=1) as home:
        await home.commission("lamp", DeviceState(text="off"))
        await new_lamp(home, CODE)
        response = await commission(home.watcher, CODE)
        assert (response.problem, "max_nodes" in response.message) == ("refused", True)


async def test_an_unknown_device_cannot_be_removed() -> None:
    async with house() as home:
        response = await decommission(home.watcher, "node-9")
    assert (response.problem, "'node-9'" in response.message) == ("refused", True)


async def test_without_a_server_nothing_is_commissioned() -> None:
    async with gateway_to("ws://127.0.0.1:9/ws") as (_, watcher):
        assert (await commission(watcher, CODE)).problem == "unreachable"


@dataclass
class Recording:
    """A server that answers with what was recorded.

    Attributes:
        answers: The frames to send for each command, in turn.
        received: The commands that it received.
    """

    answers: dict[str, list[list[str]]]
    received: list[dict[str, object]] = field(default_factory=list)

    async def answer(self, request: web.Request) -> web.StreamResponse:
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        await socket.send_json(FRAMES["greeting"])
        async for message in socket:
            command = json.loads(message.data)
            self.received.append(command)
            for name in self.answers[command["command"]].pop(0):
                frame = FRAMES[name]
                await socket.send_json(
                    frame | {"message_id": command["message_id"]} if "message_id" in frame else frame
                )
        return socket


@asynccontextmanager
async def recorded(**answers: list[list[str]]) -> AsyncIterator[tuple[Recording, Node]]:
    recording = Recording({"start_listening": [["no_nodes"]], **answers})
    async with serving(recording.answer) as url, gateway_to(f"{url}/ws") as (_, watcher):
        yield recording, watcher


async def test_recorded_frames_of_a_real_server_are_understood() -> None:
    async with recorded(
        commission_with_code=[
            ["not_commissioned"],
            ["wrong_arguments"],
            ["node_added", "node_updated", "commissioned"],
        ],
        device_command=[["commanded", "attribute_updated", "pressed"], ["timed_out"]],
        remove_node=[["no_node"], ["node_removed", "removed"]],
    ) as (recording, watcher):
        reports = watcher.create_subscription(Report, "/gateway/matter/readings", qos_profile=KEPT)
        sightings = watcher.create_subscription(Sighting, "/gateway/matter/received_topics", qos_profile=KEPT)
        assert "pairing mode" in (await commission(watcher, CODE)).message
        assert (await commission(watcher, CODE)).problem == "refused"
        joined = await commission(watcher, CODE)
        assert (joined.success, joined.key, joined.name) == (True, "node-2", "Hall light")
        assert recording.received[-1]["args"] == {"code": CODE, "network_only": True}
        (light, *_) = [one for one in iter(sightings.take, None) if one.kind == "appeared"]
        assert [part.service_type for part in light.parts] == ["light", "generic_switch"]
        assert light.identifiers == (
            "mac:e20199215011",
            PLACE,
            "id:matter:uniqueid_bXldtMr5HMmSNjHtoWX0hdmzwSotnzWX",
            "id:peer-1",
        )
        await reading(reports, "on_off", False)
        send = watcher.create_client(SendCommand, "/gateway/matter/send_command")
        order = Command(key="node-2", part="1", capability="on_off", value=Value.of(True))
        assert (await send.call(order)).success
        await reading(reports, "on_off", True)
        await reading(reports, "press", "single")
        assert (await send.call(order)).problem == "unreachable"
        assert "does not exist" in (await decommission(watcher, "node-2")).message
        assert (await decommission(watcher, "node-2")).success
        assert recording.received[-1]["args"] == {"node_id": 2}
        kinds = [one.kind for one in iter(sightings.take, None)]
        assert kinds[-1] == "removed"
