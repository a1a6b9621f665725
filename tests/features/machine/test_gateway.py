"""The gateway to a gateway of another machine: news after a gap, calls in time and once, and proofs of the secret."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from pydantic import SecretStr
from tests.features.machine.far_machine import SECRET, FarMachine, far_machine
from tests.patience import PATIENCE

from homebot.devices import GatewayState, RawCommand, Sighting
from homebot.devices.gateway_messages import Command, Report, SendCommand
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.names import PairingNames
from homebot.devices.value import Value
from homebot.errors import PeerError
from homebot.features.machine.gateway import MachineGateway
from homebot.features.machine.messages import (
    CallGateway,
    CallGatewayRequest,
    CallGatewayResponse,
    FollowGateway,
    FollowGatewayRequest,
    machine_name,
)
from homebot.features.machine.wire import MachineWire
from homebot.gateways import Gateway
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.pairing import Pair, PairingServices, PairRequest, PairResponse, UnpairedDevice
from homebot.graph import Graph, Node
from homebot.messages.cdr import message_to_cdr
from homebot.messages.message import Message
from homebot.testing.gateway_contract.steps import KEPT, active, listen, until
from homebot.testing.gateway_contract.world import running

pytestmark = pytest.mark.slow


def lamp(key: str) -> GatewayDevice:
    return GatewayDevice(key, key, (simple_part("light", settable=("on_off",)),))


@asynccontextmanager
async def house(
    folder: Path, secret: str = SECRET, **settings: object
) -> AsyncIterator[tuple[FarMachine, MachineGateway]]:
    """Run the other machine, and the gateway to it."""
    async with far_machine() as far, Node(Graph(), "attic", namespace="/gateway") as node:
        near = far.near(node, folder, secret=secret)
        async with running(near):
            yield far, near


def same(message: Message) -> dict[str, object]:
    """Return what both sides have of a message."""
    return {
        name: value for name, value in message.__dict__.items() if name not in {"gateway", "heard_at", "why", "kind"}
    }


def all_of(gateway: Gateway) -> list[dict[str, object]]:
    """Return the newest sighting of each device, and the newest report of each stream."""
    found: list[Message] = []
    for kind, topic in ((Sighting, gateway.names.received_topics), (Report, gateway.names.readings)):
        source = gateway.node.create_subscription(kind, topic, qos_profile=KEPT)
        found += iter(source.take, None)
        source.close()
    return sorted((same(one) for one in found), key=lambda one: (str(one["key"]), str(one.get("stream"))))


async def test_after_a_lost_link_all_is_as_at_the_source(tmp_path: Path) -> None:
    async with house(tmp_path) as (far, near):
        states = listen(near.node, GatewayState, near.names.state)
        sightings = listen(near.node, Sighting, near.names.received_topics)
        reports = listen(near.node, Report, near.names.readings)
        for number in range(200):
            far.gateway.devices.put(lamp(f"lamp{number}"), "new")
            await far.gateway.devices.report(f"lamp{number}", {"on_off": False})
        far.gateway.devices.report_reachable("lamp7", reachable=True)
        await until(sightings, "the last lamp", lambda one: one.key == "lamp199")
        await far.lose_link()
        await until(states, "the loss", lambda one: one.state == "unavailable")
        far.gateway.devices.remove("lamp5", "it was sold")
        far.gateway.devices.put(lamp("new"), "new")
        await far.gateway.devices.report("lamp6", {"on_off": True})
        await far.gateway.devices.report("new", {"on_off": True})
        await far.mend_link()
        await active(states)
        await until(sightings, "the removal", lambda one: (one.key, one.kind) == ("lamp5", "removed"))
        await until(reports, "the last report", lambda one: one.key == "new")
        wanted = all_of(far.gateway)
        assert all_of(near) == wanted
        assert len(wanted) == 200 + 200 + 1


async def test_the_times_of_a_machine_whose_clock_is_wrong_are_those_of_the_clock_here(tmp_path: Path) -> None:
    async with far_machine(epoch=1e9) as far, Node(Graph(), "attic", namespace="/gateway") as node:
        near = far.near(node, tmp_path)
        async with running(near):
            sightings = listen(node, Sighting, near.names.received_topics)
            reports = listen(node, Report, near.names.readings)
            far.gateway.devices.put(lamp("lamp"), "new")
            await far.gateway.devices.report("lamp", {"on_off": True})
            sighting, report = await until(sightings, "the lamp"), await until(reports, "its report")
            assert abs(sighting.seen_at.to_seconds() - node.graph.clock.now()) < PATIENCE
            assert abs(report.received_at.to_seconds() - node.graph.clock.now()) < PATIENCE
            assert sighting.expires_at.to_seconds() - sighting.seen_at.to_seconds() == pytest.approx(3600.0)


async def test_what_is_longer_than_any_announcement_of_a_device_is_refused_and_counted(tmp_path: Path) -> None:
    async with house(tmp_path) as (far, near):
        sightings = listen(near.node, Sighting, near.names.received_topics)
        for key in ("x" * 1001, "<b>", "last"):
            far.gateway.devices.put(lamp(key), "new")
        assert [(await until(sightings, "a lamp")).key for _ in range(2)] == ["<b>", "last"]
        health = await near.node.create_client(GetHealth, near.names.health).call(HealthRequest())
        assert ("announcements_refused", 1) in {(one.name, one.count) for one in health.counts}


async def test_another_secret_is_refused_on_both_sides(tmp_path: Path) -> None:
    async with house(tmp_path, "a guess") as (far, near):
        why = "do not have the same secret: see token_file and password_file"
        await until(listen(near.node, GatewayState, near.names.state), why, lambda state: why in state.reason)
        answer = await near.node.create_client(SendCommand, near.names.send_command).call(command("lamp"))
        assert (answer.success, answer.problem) == (False, "unreachable")
        assert not far.gateway.commands


def command(key: str, **change: object) -> Command:
    asked = {"key": key, "part": "", "capability": "on_off", "value": Value.of(True), "id": "1", **change}
    return Command.model_validate(asked)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"until": 1.0}, "too late, and was not carried out"),
        ({"arrives_by": 1.0}, "too late, and was not carried out"),
        ({"session": "before"}, "its machine has started anew"),
        ({"follower": "somebody"}, "another homebot follows this gateway by now"),
        ({"id": 0}, "this call came before; it is carried out once"),
    ],
    ids=["late", "lost", "restarted", "other", "again"],
)
async def test_a_command_is_not_carried_out_late_for_another_start_or_twice(
    change: dict[str, object], why: str
) -> None:
    async with far_machine() as far, Node(Graph(), "caller") as node:
        far.gateway.devices.put(lamp("lamp"), "new")
        assert far.link.session is not None
        wire = MachineWire(node, far.link.session, SecretStr(SECRET))
        follow, call = (machine_name("villa", "attic", "memory", one) for one in ("follow", "call"))
        news = await wire.ask(follow, FollowGateway, FollowGatewayRequest(follower="me", number=0), PATIENCE)

        async def called(**given: object) -> CallGatewayResponse:
            asked = {"session": news.session, "follower": "me", "id": 1, "until": news.now + PATIENCE, "longest": 5.0}
            sent = {"service": "send_command", "request": message_to_cdr(command("lamp"))}
            return await wire.ask(call, CallGateway, CallGatewayRequest.model_validate(asked | sent | given), PATIENCE)

        assert (await called(id=0)).success
        try:
            problem = (await called(**change)).message
        except PeerError as exc:
            problem = str(exc)
        assert why in problem
        assert len(far.gateway.commands) == 1


@pytest.mark.parametrize("seconds", [5.0, 8.0, 9.5])
async def test_what_was_sent_into_a_link_that_hung_is_never_carried_out_once_it_is_back(
    tmp_path: Path, seconds: float
) -> None:
    """It is connected all the time, so what was sent arrives: after newer commands were told that they were not."""
    outcomes: dict[str, str] = {}
    locks = Locks()
    async with (
        far_machine() as far,
        Node(Graph(), "attic", namespace="/gateway") as node,
        anyio.create_task_group() as tasks,
    ):
        PairingServices(locks, far.gateway.node)
        far.gateway.devices.put(lamp("window"), "new")
        near = far.near(node, tmp_path)
        await tasks.start(near.serve)
        states = listen(near.node, GatewayState, near.names.state)
        reports = listen(near.node, Report, near.names.readings)
        await active(states)
        pairing = near.node.create_client(Pair, PairingNames(near.node.name).pair)
        assert await pairing.wait_for_service(PATIENCE)
        commands = near.node.create_client(SendCommand, near.names.send_command)
        texts = near.node.create_publisher(RawCommand, near.names.out)
        wanted, lasts = {"expires_after": 20.0}, 25.0

        async def send(name: str) -> None:
            with anyio.fail_after(10.0):
                outcomes[name] = (await commands.call(command("window", id=name, **wanted), lasts)).problem

        async def pair() -> None:
            with anyio.fail_after(10.0):
                outcomes["pair"] = (await pairing.call(PairRequest(device="lock", code="1"), 120.0)).problem

        far.wire.hang()
        back_at = anyio.current_time() + seconds
        for number in range(3):
            texts.publish(RawCommand(address="memory/window", payload="open"))
            tasks.start_soon(send, f"open {number}")
            tasks.start_soon(pair)
            await anyio.sleep(0.8)
        await anyio.sleep_until(back_at - 0.8)
        await send("close")
        assert outcomes == {"open 0": "unanswered", "open 1": "unanswered", "open 2": "unanswered"} | {
            "pair": "unreachable",
            "close": "unreachable",
        }
        await anyio.sleep_until(back_at)
        far.wire.go_on()
        await active(states)
        await send("last")
        await until(reports, "the answer of the window", lambda one: one.key == "window")
        assert [one.id for one in far.gateway.commands] == ["last"]
        assert not far.gateway.raw_commands
        assert not locks.paired
        tasks.cancel_scope.cancel()


async def test_pairing_and_health_go_to_the_other_machine(tmp_path: Path) -> None:
    async with house(tmp_path) as (far, near):
        states = listen(near.node, GatewayState, near.names.state)
        await active(states)
        names = PairingNames(near.node.name)
        assert names.pair not in near.node.graph.get_service_names_and_types()
        await far.lose_link()
        await until(states, "the loss", lambda one: one.state == "unavailable")
        lost = await near.node.create_client(GetHealth, near.names.health).call(HealthRequest())
        assert not lost.troubles  # the state says it
        locks = Locks()
        PairingServices(locks, far.gateway.node)
        await far.mend_link()
        client = near.node.create_client(Pair, names.pair)
        assert await client.wait_for_service(PATIENCE)
        assert await client.call(PairRequest(device="lock", code="123")) == PairResponse(
            success=True, key="lock", name="the lock"
        )
        assert locks.paired == [("lock", "123")]
        health = await near.node.create_client(GetHealth, near.names.health).call(HealthRequest())
        assert {"commands", "news_missed"} <= {one.name for one in health.counts}


class Locks:
    """A gateway that pairs with a lock."""

    acts, observes_because = True, ""

    def __init__(self) -> None:
        self.paired: list[tuple[str, str]] = []

    async def pair(self, key: str, code: str) -> str:
        self.paired.append((key, code))
        return "the lock"

    async def unpair(self, key: str) -> str:
        return key

    def unpaired(self) -> tuple[UnpairedDevice, ...]:
        return ()


@pytest.mark.parametrize(
    ("gateways", "why"),
    [
        (("mqtt", "ble"), "its machine has the gateways mqtt, ble; name it here"),
        ((), "its machine has no gateways yet"),
    ],
)
async def test_a_machine_with_more_or_less_than_one_gateway_asks_for_a_name(
    tmp_path: Path, gateways: tuple[str, ...], why: str
) -> None:
    async with far_machine() as far, Node(Graph(), "attic", namespace="/gateway") as node:
        await far.lose_link()
        await far.mend_link(gateways)
        async with running(far.near(node, tmp_path)):
            await until(listen(node, GatewayState, "/gateway/attic/state"), why, lambda state: why in state.reason)


async def test_a_machine_says_whether_a_homebot_follows_its_gateways(tmp_path: Path) -> None:
    async with far_machine() as far, Node(Graph(), "attic", namespace="/gateway") as node:
        health = far.gateway.node.create_client(GetHealth, "/machine/health")
        (trouble,) = (await health.call(HealthRequest())).troubles
        assert trouble == "no homebot of villa follows memory; does it have attic as a gateway, and run?"
        async with running(far.near(node, tmp_path)):
            await active(listen(node, GatewayState, "/gateway/attic/state"))
            assert not (await health.call(HealthRequest())).troubles


async def test_two_machines_with_one_name_are_told_of(tmp_path: Path) -> None:
    """As from a copied card: no command is carried out twice, but each answer is of another one."""
    async with house(tmp_path) as (far, near):
        states = listen(near.node, GatewayState, near.names.state)
        await active(states)
        await far.copy()
        why = "two machines answer as attic; stop one"
        await until(states, why, lambda state: why in state.reason)


async def test_two_homes_on_one_network_do_not_mix(tmp_path: Path) -> None:
    async with (
        far_machine() as far,
        Node(Graph(), "attic", namespace="/gateway") as node,
        running(far.near(node, tmp_path, home="other")),
    ):
        state = await until(listen(node, GatewayState, "/gateway/attic/state"), "the state")
        assert "its machine does not answer" in state.reason
