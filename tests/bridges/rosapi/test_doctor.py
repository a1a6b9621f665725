"""The doctor as a service: it asks all parts of homebot at once."""

import anyio
import pytest

from homebot.bridges.rosapi import doctor
from homebot.devices import QUERY_DEVICES, GatewayState, QueryDevices
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.devices.names import GatewayNames
from homebot.devices.services import QueryDevicesRequest, QueryDevicesResponse
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.support.counters import Severity

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


async def test_a_failed_command_is_no_problem_any_more_after_ten_minutes() -> None:
    failed = 0
    graph = Graph()
    async with Node(graph, "rosapi") as rosapi, Node(graph, "hub") as hub:
        hub.create_service(QueryDevices, QUERY_DEVICES, no_devices)
        hub.create_service(
            GetHealth,
            "/hub/health",
            lambda _: HealthResponse(counts=Count.each({"commands_failed": failed}, Severity.LOSS)),
        )
        doctor.serve(rosapi)
        client = hub.create_client(doctor.Examine, "/rosapi/doctor")

        async def told() -> list[tuple[str, str]]:
            found = await client.call(doctor.ExamineRequest())
            return [(one.code, one.rows[0].why) for one in found.findings]

        await anyio.sleep(86_400)
        failed = 1
        assert await told() == [("HB204", "1")]
        await anyio.sleep(240)
        assert await told() == [("HB204", "1")]
        await anyio.sleep(420)
        assert await told() == [("HB207", "1")]
        failed = 3
        assert await told() == [("HB204", "2")]
