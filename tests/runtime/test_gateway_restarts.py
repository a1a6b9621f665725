"""A gateway that keeps crashing: everybody is told, and it starts again by hand, or by itself after an hour."""

import sys
from typing import ClassVar

import anyio
import pytest
from anyio.abc import TaskStatus
from pydantic import BaseModel

from homebot.bridges.rosapi.doctor import Examine, ExamineRequest, ExamineResponse
from homebot.devices.findings import Findings
from homebot.devices.gateway_messages import GatewayState, RestartGateway, RestartGatewayRequest
from homebot.devices.names import ALERT_FINDINGS, RESTART_GATEWAY, GatewayNames
from homebot.gateways import Gateway
from homebot.gateways.base import GatewaySettings
from homebot.graph import Node, qos_profile_latched
from homebot.testing import VirtualHouse

pytestmark = pytest.mark.virtual_time


class FragileGateway(Gateway):
    """Works for a second, then crashes while it is broken."""

    Settings: ClassVar[type[BaseModel]] = GatewaySettings
    is_broken: ClassVar[bool] = True
    starts: ClassVar[list[float]] = []

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        self.starts.append(anyio.current_time())
        state = self.node.create_publisher(GatewayState, self.names.state, qos_profile_latched)
        state.publish(GatewayState(state="active", reason="", acts=True))
        task_status.started()
        await anyio.sleep(1)
        if self.is_broken:
            raise RuntimeError("no radio")
        await anyio.sleep_forever()


HOUSE = pytest.mark.house(
    allow_crashes=True,
    config={"notify": {}, "gateways": {"mqtt": {}, "radio": {"class": f"{__name__}:FragileGateway"}}},
)


@pytest.fixture(autouse=True)
def _importable(monkeypatch: pytest.MonkeyPatch) -> None:
    """As ``module:Class`` is looked up: by the name of the module."""
    monkeypatch.setitem(sys.modules, __name__, sys.modules[__name__])
    FragileGateway.starts, FragileGateway.is_broken = [], True


async def doctor(node: Node) -> ExamineResponse:
    return await node.create_client(Examine, "/rosapi/doctor").call(ExamineRequest())


async def restart(node: Node, gateway: str) -> tuple[bool, str]:
    answer = await node.create_client(RestartGateway, RESTART_GATEWAY).call(RestartGatewayRequest(gateway=gateway))
    return answer.success, answer.message


@HOUSE
async def test_one_that_is_given_up_is_told_as_away_with_what_to_do(house: VirtualHouse) -> None:
    async with Node(house.runtime.graph, "asking") as node:
        await house.run_for("5m")
        assert len(FragileGateway.starts) == 5
        found = await doctor(node)
        (shown,) = [one for one in found.gateways if one.name == "radio"]
        assert shown.text == (
            "gateway radio is unavailable: it crashed (RuntimeError: no radio) and starts again in 60 minutes; "
            "at once: homebot gateway restart radio"
        )
        assert {"HB302", "HB202"} <= {one.code for one in found.findings if one.is_problem}
        findings = await node.create_subscription(Findings, ALERT_FINDINGS, None, qos_profile_latched).receive()
        assert [one.code for one in findings.findings] == ["HB302"]
    assert [one.text for one in house.notifications] == ["Alert: gateway radio is away"]


@HOUSE
async def test_one_that_was_given_up_starts_by_hand(house: VirtualHouse) -> None:
    async with Node(house.runtime.graph, "asking") as node:
        await house.run_for("5m")
        FragileGateway.is_broken = False
        assert await restart(node, "radio") == (True, "gateway radio starts again")
        await house.run_for("10m")
        states = node.create_subscription(GatewayState, GatewayNames("radio").state, None, qos_profile_latched)
        assert (await states.receive()).state == "active"
        assert "HB302" not in {one.code for one in (await doctor(node)).findings}
        assert house.runtime.supervisor.given_up == []
    assert [one.text for one in house.notifications][1:] == ["Over: gateway radio is back"]


@HOUSE
async def test_one_that_was_given_up_starts_by_itself_after_an_hour(house: VirtualHouse) -> None:
    await house.run_for("30m")
    FragileGateway.is_broken = False
    await house.run_for("31m")
    assert len(FragileGateway.starts) == 6
    assert house.runtime.supervisor.given_up == []


@HOUSE
async def test_one_that_works_is_stopped_and_started_by_hand(house: VirtualHouse) -> None:
    FragileGateway.is_broken = False
    async with Node(house.runtime.graph, "asking") as node:
        await house.run_for("1m")
        before = len(FragileGateway.starts)
        await restart(node, "radio")
        await house.run_for("1s")
        assert len(FragileGateway.starts) == before + 1
        assert await restart(node, "radoi") == (False, "there is no gateway 'radoi'; did you mean radio?")
        assert (await restart(node, "control"))[0] is False
