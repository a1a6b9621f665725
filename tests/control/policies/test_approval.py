"""A device that can hurt is listed and not driven until the owner approved it."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.control.conftest import Home, OpenHome, hold_request
from tests.control.policies.houses import make_command, make_device, make_facts

from homebot.control import Control, ControlSettings
from homebot.control.policies import Verdict
from homebot.control.policies.rights import check_approval
from homebot.control.policy_engine import Policies
from homebot.devices import FIND_DEVICES, Fact, FindDevices
from homebot.devices.always_ask import always_asks, waits_for_approval
from homebot.devices.approval_messages import ApproveDevice, GetUnapproved
from homebot.devices.command_messages import CommandRequest, CommandResult, Setting
from homebot.devices.device import KeyValue, Route
from homebot.devices.handles import DoorLock, Light
from homebot.devices.health import GetHealth
from homebot.devices.names import APPROVE_DEVICE, GET_UNAPPROVED
from homebot.devices.outcomes import Refused
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.term_messages import read_terms
from homebot.devices.query.terms import IsUnapproved
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse
from homebot.devices.value import PlainValue, Value
from homebot.graph import Graph, Node
from homebot.messages import Time

KINDS = {
    "light": ("on_off", (True, False)),
    "plug": ("on_off", (True, False)),
    "door_lock": ("lock", ("locked", "unlocked", "open")),
    "closure": ("movement", ("open", "closed", "stopped")),
    "water_valve": ("valve", ("open", "closed")),
    "x_alarm_panel": ("alarm", ("armed_away", "disarmed")),
}


def judged(
    kind: str, value: PlainValue, *facts: Fact, key: str = "it", issuer: str = "/app", approved: str = ""
) -> Verdict:
    capability = KINDS[kind][0]
    device = make_device(key, kind, settable=(capability,), facts=facts, approved=approved)
    return check_approval(make_command(device, {capability: value}, issuer, ("act: all",)), make_facts())


@pytest.mark.parametrize("issuer", ["/app", "client:owner", "client:local"])
def test_a_lock_that_is_not_approved_is_unlocked_by_nobody(issuer: str) -> None:
    verdict = judged("door_lock", "unlocked", key="front door", issuer=issuer)
    assert (verdict.policy, verdict.allowed) == ("approval", False)
    assert "the owner has not approved it; approve it with `homebot approve 'front door'`" in verdict.reason
    assert [(one.name, one.value) for one in verdict.facts] == [("approved of front door", False)]


def test_a_refusal_says_what_changed_since_the_approval() -> None:
    changed = Fact(
        name="changed_since_approval",
        value="its commands go to garage/cmd/set instead of door/set",
        gateway="memory",
        convention="owner",
        key="it",
        said_at=Time.from_seconds(0),
    )
    verdict = judged("door_lock", "locked", changed)
    assert (
        "it changed since the owner approved it: its commands go to garage/cmd/set instead of door/set"
        in verdict.reason
    )


def test_a_capability_that_only_another_route_takes_is_not_approved() -> None:
    device = make_device("it", "door_lock", settable=("lock", "text"))
    routes = (
        Route(gateway="memory", key="it", part="", takes=("lock",), approved="digest"),
        Route(gateway="memory", key="later", part="", takes=("text",)),
    )
    device = device.model_copy(update={"parts": (device.parts[0].model_copy(update={"routes": routes}),)})
    lock, text = make_command(device, {"lock": "locked"}), make_command(device, {"text": "1234"})
    assert check_approval(lock, make_facts()).allowed
    assert not check_approval(text, make_facts()).allowed


def test_a_part_that_joined_an_approved_device_waits_by_itself() -> None:
    device = make_device("it", "door_lock", settable=("lock",), approved="digest")
    (own,) = device.parts
    later = own.model_copy(update={"id": "later", "routes": (Route(gateway="memory", key="later", part=""),)})
    joined = device.model_copy(update={"parts": (own, later)})
    command = replace(make_command(joined, {"lock": "locked"}), part=later)
    verdict = check_approval(command, make_facts())
    assert not verdict.allowed
    assert "it was announced after the owner approved the device" in verdict.reason
    assert check_approval(make_command(joined, {"lock": "locked"}), make_facts()).allowed
    assert waits_for_approval(joined)


@pytest.mark.parametrize("value", [True, False])
def test_the_relay_of_a_door_opener_is_not_told_anything_before_its_approval(*, value: bool) -> None:
    """Told that it is off, the relay moves the door too."""
    opener = make_device("opener", "switch", settable=("on_off",))
    opener = opener.model_copy(update={"metadata": (KeyValue(key="model", value="Garage door opener"),)})
    assert not check_approval(make_command(opener, {"on_off": value}, "/app", ("act: all",)), make_facts()).allowed


def test_a_setting_that_can_hurt_is_not_turned_off_before_its_approval() -> None:
    relock = make_device("relock", "x_setting", settable=("on_off", "lock"))
    assert not check_approval(make_command(relock, {"on_off": False}, "/app", ("act: all",)), make_facts()).allowed


@given(
    st.sampled_from(sorted(KINDS)).flatmap(lambda kind: st.tuples(st.just(kind), st.sampled_from(KINDS[kind][1]))),
    st.sampled_from(["it", "Oven", "Main valve", "Lamp"]),
    st.sampled_from(["", "digest"]),
)
def test_every_command_to_what_can_hurt_takes_an_approval_to_the_safe_side_too(
    wanted: tuple[str, PlainValue], key: str, approved: str
) -> None:
    kind, value = wanted
    device = make_device(key, kind, settable=(KINDS[kind][0],))
    verdict = judged(kind, value, key=key, approved=approved)
    assert verdict.allowed is (bool(approved) or not always_asks(device, device.parts[0]))
    assert verdict.allowed or verdict.reason


def test_the_configuration_turns_it_off() -> None:
    lock = make_device("lock", "door_lock", settable=("lock",))
    command = make_command(lock, {"lock": "unlocked"}, scope=("act: all",))
    assert not Policies(ControlSettings()).check(command, make_facts())[-1].allowed
    assert Policies(ControlSettings(approvals=False)).check(command, make_facts())[-1].allowed


async def approve(home: Home, device: str, *, remove: bool = False) -> None:
    client = home.app.create_client(ApproveDevice, APPROVE_DEVICE)
    assert (await client.call(ApproveDevice.Request(device=device, remove=remove))).success


async def waiting(home: Home, device: str = "") -> tuple[str, ...]:
    return (
        await home.app.create_client(GetUnapproved, GET_UNAPPROVED).call(GetUnapproved.Request(device=device))
    ).devices


async def unlock(home: Home, device: str, issuer: str = "client:owner") -> CommandResult:
    setting = Setting(capability="lock", value=Value.of("unlocked"))
    request = CommandRequest(device=device, part="", settings=(setting,), issuer=issuer, scope=("act: all",))
    return CommandResult.of(await home.control.perform(request))


@pytest.mark.virtual_time
async def test_what_is_not_approved_is_held_by_nobody(open_home: OpenHome) -> None:
    async with open_home(grants={"/app": ("act: all",)}, approvals=True) as home:
        lock = await home.new(DoorLock, "lock", "lock")
        async with lock.hold("unlock", by="robot") as held:
            assert isinstance(held.outcome, Refused)
            assert (held.outcome.policy, held.is_held) == ("approval", False)
        async with lock.hold("lock", by="guard") as held:
            assert not held.is_held
        await approve(home, lock.device.id)
        async with lock.hold("unlock", by="robot") as held:
            assert held.succeeded
            await approve(home, lock.device.id, remove=True)
            assert held.is_held
        assert [one.value.plain() for one in home.commands] == ["unlocked"]


@pytest.mark.virtual_time
async def test_a_device_of_a_client_that_is_not_approved_blocks_nobody(open_home: OpenHome) -> None:
    async with open_home(grants={"/app": ("act: all",)}, approvals=True) as home:
        lock = await home.new(DoorLock, "lock", "lock")
        wanted = hold_request(lock.device.id, "lock", "unlocked", "client:owner", ttl=3600, scope=("act: all",))
        answer = await home.hold(wanted)
        assert (answer.held, answer.result.outcome, answer.result.policy) == (False, "refused", "approval")
        kinds = [one.kind for one in (await home.read()).entries]
        assert kinds == ["denied"]  # it was held at no time


@pytest.mark.virtual_time
async def test_who_asks_which_devices_wait_has_only_those_read() -> None:
    """Of a whole house: the directory finds them by its index, and nobody reads the others a second time."""
    asked: list[object] = []

    def find(request: FindDevicesRequest) -> FindDevicesResponse:
        asked.append(request.ids or read_terms(request.query))
        return FindDevicesResponse(devices=(), sequence=1)

    graph = Graph()
    async with Node(graph, "discovery") as directory, Node(graph, "control") as node, Node(graph, "app") as app:
        directory.create_service(FindDevices, FIND_DEVICES, find)
        Control(node).register()
        await app.create_client(GetHealth, "/control/health").call(GetHealth.Request())
        await app.create_client(GetUnapproved, GET_UNAPPROVED).call(GetUnapproved.Request(device="Lock"))
    assert asked == [IsUnapproved(), ("Lock",)]


@given(st.lists(st.tuples(st.sampled_from(sorted(KINDS)), st.sampled_from(["", "digest"]))))
def test_a_query_finds_what_waits(devices: list[tuple[str, str]]) -> None:
    for kind, approved in devices:
        device = make_device("it", kind, settable=(KINDS[kind][0],), approved=approved)
        waits = waits_for_approval(device)
        assert fits(IsUnapproved(), facets_of(device)) is waits
        assert fits(IsUnapproved(), PartFacets(device)) is waits


@pytest.mark.virtual_time
async def test_a_new_lock_is_listed_and_not_driven_until_it_is_approved(open_home: OpenHome) -> None:
    async with open_home(grants={"/app": ("act: all",)}, approvals=True) as home:
        home.put("lock", "door_lock", "lock")
        home.put("lamp", "light", "on_off")
        lock = await home.handle(DoorLock, "lock")
        assert (await (await home.handle(Light, "lamp")).turn_on()).succeeded
        outcome = await lock.unlock()
        assert isinstance(outcome, Refused)
        assert outcome.policy == "approval"
        assert (await unlock(home, lock.device.id)).outcome == "refused"
        assert isinstance(await lock.lock(), Refused)
        await approve(home, lock.device.id)
        assert (await lock.unlock()).succeeded
        await approve(home, lock.device.id)  # again is fine
        await approve(home, lock.device.id, remove=True)
        assert isinstance(await lock.lock(), Refused)
        assert [one.value.plain() for one in home.commands] == [True, "unlocked"]


@pytest.mark.virtual_time
async def test_who_asks_learns_which_devices_wait(open_home: OpenHome) -> None:
    async with open_home(approvals=True) as home:
        home.put("lamp", "light", "on_off")
        home.put("lock", "door_lock", "lock")
        home.put("lock_2", "door_lock", "lock")
        await home.handle(Light, "lamp")
        health = home.app.create_client(GetHealth, "/control/health")
        assert await waiting(home) == ("lock", "lock_2")
        assert await waiting(home, "lock") == ("lock",)
        assert await waiting(home, "lamp") == ()
        (note,) = (await health.call(GetHealth.Request())).notes
        assert note.startswith("2 devices wait for approval")
        assert note.endswith("lock (it is a door lock), lock_2 (it is a door lock)")
        for one in await waiting(home):
            await approve(home, one)
        assert await waiting(home) == ()
        assert (await health.call(GetHealth.Request())).notes == ()
    async with open_home() as home:
        await home.new(DoorLock, "lock", "lock")
        assert await waiting(home) == ()
