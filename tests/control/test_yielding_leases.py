"""Leases that yield to persons, as those of an identification: a person's command is obeyed; in virtual time."""

from functools import partial

import anyio
import pytest
from anyio.lowlevel import checkpoint
from tests.control.conftest import Home, hold_request, obey_after
from tests.control.test_groups import put_group

from homebot.devices.command_messages import CommandRequest, PerformCommand, SendText, SendTextRequest, Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.lease_messages import HolderRequest, HoldRequest, LeaseResponse, RenewLease
from homebot.devices.names import PERFORM_COMMAND, RENEW_LEASE, SEND_TEXT
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Outcome, Refused
from homebot.devices.trigger import Trigger
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part

pytestmark = pytest.mark.virtual_time


def blinking(*, value: PlainValue = True, device: str = "lamp", **fields: object) -> HoldRequest:
    """Return the request of who blinks."""
    return hold_request(device, "on_off", value, "client:rosie", ttl=60.0, yields_to_persons=True, **fields)


async def command(
    home: Home,
    value: PlainValue,
    issuer: str = "client:owner",
    device: str = "lamp",
    trigger: str = "",
    batch: str = "",
    batch_size: int = 0,
) -> Outcome:
    settings = (Setting.of("on_off", value),)
    request = CommandRequest(
        device=device,
        part="",
        settings=settings,
        issuer=issuer,
        trigger=Trigger.model_validate({"kind": trigger}),
        batch=batch,
        batch_size=batch_size,
    )
    return await home.app.create_client(PerformCommand, PERFORM_COMMAND).call(request, timeout=60)


async def steps(home: Home) -> list[tuple[str, str, str]]:
    kinds = {"held", "released", "ended", "expired", "outranked", "handed_back"}
    return [(one.kind, one.issuer, one.text) for one in (await home.read()).entries if one.kind in kinds]


@pytest.mark.parametrize(("value", "outcome"), [(False, Confirmed), (True, AlreadySo)])
async def test_a_person_is_obeyed_and_nothing_is_commanded_again(
    home: Home, value: PlainValue, outcome: type[Outcome]
) -> None:
    """Also one who wants what is held just now, and though the lamp reports it once more."""
    await home.lamp("on_off")
    assert (await home.hold(blinking())).held
    assert isinstance(await command(home, value), outcome)
    commands = len(home.commands)
    await home.report("lamp", "on_off", value)
    await anyio.sleep(59)
    (held,) = await home.leases()
    assert held.saw == "a command by the client owner"
    assert held.outranked_until.to_seconds() == pytest.approx(held.holders[0].until.to_seconds())
    await anyio.sleep(600)
    assert len(home.commands) == commands
    assert await steps(home) == [
        ("held", "client:rosie", "robot"),
        ("outranked", "client:owner", "a command by the client owner"),
        ("expired", "client:rosie", "robot"),
    ]


async def test_who_holds_another_value_after_a_person_is_refused(home: Home) -> None:
    await home.lamp("on_off")
    assert (await home.hold(blinking())).held
    assert (await home.hold(blinking(value=False))).held
    await command(home, True)
    answer = await home.hold(blinking(value=True))
    assert (answer.held, answer.result.policy) == (False, "lease")
    assert answer.result.reason == "a command by the client owner, which outranks leases for 60 s more"
    assert (await home.hold(blinking(value=False, lease="other"))).result.outcome == "refused"
    assert [one.value.plain() for one in home.commands] == [True, False, True]


@pytest.mark.parametrize(("issuer", "trigger"), [("/app", ""), ("client:owner", "lease"), ("client:owner", "end")])
async def test_what_no_person_commands_is_refused(home: Home, issuer: str, trigger: str) -> None:
    """An app by itself, another lease, and the end of what a person began."""
    await home.lamp("on_off")
    assert (await home.hold(blinking())).held
    assert isinstance(await command(home, False, issuer, trigger=trigger), Refused)
    assert await steps(home) == [("held", "client:rosie", "robot")]


@pytest.mark.parametrize("order", [(True, False), (False, True), (False, False)])
async def test_a_person_is_refused_if_one_holder_does_not_yield(home: Home, order: tuple[bool, bool]) -> None:
    await home.lamp("on_off")
    for name, yields in zip(("first", "second"), order, strict=True):
        wanted = blinking(by=name, lease=name).model_copy(update={"yields_to_persons": yields})
        assert (await home.hold(wanted)).held
    refused = await command(home, False)
    assert isinstance(refused, Refused)
    assert refused.reason == "held on by first, second for 60 s more"


async def test_a_command_to_a_group_outranks_the_leases_of_its_members(home: Home) -> None:
    group = await put_group(home, "id:left", "id:right")
    assert (await home.hold(blinking(device="left"))).held
    await home.report("group", "on_off", True)
    assert isinstance(await command(home, False, device=group.device.id), Confirmed)
    await anyio.sleep(30)
    assert (await steps(home))[1:] == [("outranked", "client:owner", "a command by the client owner")]
    assert [one.key for one in home.commands] == ["left", "group"]


async def test_commands_to_all_members_outrank_the_lease_of_the_group_that_carries_them(home: Home) -> None:
    group = await put_group(home, "id:left", "id:right")
    assert (await home.hold(blinking(device=group.device.id))).held
    await anyio.sleep(5)
    for name in ("left", "right"):
        home.tasks.start_soon(partial(command, home, False, device=name, batch="all", batch_size=2))
    await anyio.sleep(30)
    assert (await steps(home))[1:] == [("outranked", "client:owner", "a command by the client owner")]
    assert [(one.key, one.value.plain()) for one in home.commands] == [("group", True), ("group", False)]


async def test_a_text_of_a_person_that_is_not_understood_outranks_the_leases_of_all_parts(home: Home) -> None:
    """As a JSON object of Zigbee2MQTT for one of two lights."""
    light = simple_part("light", settable=("on_off",))
    parts = tuple(light.model_copy(update={"id": one}) for one in ("left", "right"))
    home.gateway.devices.put(GatewayDevice("lamp", "Lamp", parts, command_address="lamp/set"), "it was found")
    home.behaviours["lamp"] = report_right
    await home.gateway.devices.report("lamp", {"on_off": False}, "right")
    await anyio.sleep(1)
    assert (await home.hold(blinking(part="right"))).held
    await anyio.sleep(20)
    text = SendTextRequest(device="lamp", payload='{"state_right": "OFF"}', issuer="client:owner")
    assert (await home.app.create_client(SendText, SEND_TEXT).call(text)).success
    await home.gateway.devices.report("lamp", {"on_off": False}, "right")
    await anyio.sleep(20)
    assert (await steps(home))[1:] == [("outranked", "client:owner", "a command by the client owner")]
    assert [one.value.plain() for one in home.commands] == [True]


async def report_right(home: Home, command: Command) -> None:
    await home.gateway.devices.report("lamp", {"on_off": command.value.plain()}, "right")


@pytest.mark.parametrize("turns", range(40))
async def test_a_person_is_obeyed_at_whatever_moment_of_a_change(home: Home, turns: int) -> None:
    """The held value changes, and a person commands the other one some turns of the loop later."""
    await home.lamp("on_off", behaviour=obey_after(0.2))
    assert (await home.hold(blinking())).held
    answers: list[LeaseResponse] = []

    async def change() -> None:
        answers.append(await home.hold(blinking(value=False)))

    home.tasks.start_soon(change)
    for _ in range(turns):
        await checkpoint()
    assert (await command(home, True)).succeeded
    await anyio.sleep(30)
    assert home.commands[-1].value.plain() is True
    assert answers
    assert ("outranked", "client:owner", "a command by the client owner") in await steps(home)
    await anyio.sleep(600)
    assert home.commands[-1].value.plain() is True


async def test_who_renews_hears_that_a_person_has_the_part(home: Home) -> None:
    await home.lamp("on_off")
    assert (await home.hold(blinking())).held
    await command(home, False)
    holder = HolderRequest(lease="1", by="robot", issuer="client:rosie")
    state = await home.app.create_client(RenewLease, RENEW_LEASE).call(holder)
    assert (state.held, state.outcome) == (True, Contradicted("a command by the client owner"))
