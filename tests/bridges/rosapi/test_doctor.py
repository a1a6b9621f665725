"""The doctor as a service: it asks all parts of homebot at once."""

import anyio
import pytest

from homebot.bridges.rosapi import doctor
from homebot.devices import QUERY_DEVICES, GatewayState, QueryDevices
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.names import GatewayNames
from homebot.devices.services import QueryDevicesRequest, QueryDevicesResponse
from homebot.graph import Graph, Node, qos_profile_latched

pytestmark = pytest.mark.virtual_time


def no_devices(_request: QueryDevicesRequest) -> QueryDevicesResponse:
    return QueryDevicesResponse(success=True, message="")


async def no_answer(_request: HealthRequest) -> HealthResponse:
    await anyio.sleep_forever()
    raise AssertionError


async def test_many_silent_parts_delay_the_answer_no_more_than_one_does() -> None:
    """The page waits five seconds for it."""
    graph = Graph()
    async with Node(graph, "rosapi") as rosapi, Node(graph, "asker") as asker:
        asker.create_service(QueryDevices, QUERY_DEVICES, no_devices)
        for number in range(8):
            asker.create_publisher(GatewayState, GatewayNames(f"silent{number}").state, qos_profile_latched)
            asker.create_service(GetHealth, f"/hung{number}/health", no_answer)
        doctor.serve(rosapi)
        found = await asker.create_client(doctor.Examine, "/rosapi/doctor").call(doctor.ExamineRequest(), 4.5)
    assert [one.state for one in found.gateways] == ["silent"] * 8
    assert [one.code for one in found.findings] == ["HB301"] * 8 + ["HB201"] * 8
