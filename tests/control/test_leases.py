"""Leases: a part stays as somebody holds it; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from structlog.testing import capture_logs
from tests.control.conftest import Home, OpenHome, hold_request, ignore, obey, obey_after, refusal, report
from tests.sizes import examples

from homebot.control.durations import REMEMBERED
from homebot.control.leases import MAX_HOLDERS, MAX_HOLDERS_OF_ISSUER, Lease, LeaseHolder, Leases
from homebot.devices import GatewayNames, RawCommand
from homebot.devices.command_messages import (
    CommandDevices,
    CommandDevicesRequest,
    CommandRequest,
    PerformCommand,
    Setting,
)
from homebot.devices.gateway_messages import Command, CommandAnswer
from homebot.devices.handles import Closure, DoorLock, Thermostat
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.lease_messages import EndLeases, HeldPart, HolderRequest, HoldRequest, ReleaseLease, RenewLease
from homebot.devices.names import COMMAND_DEVICES, END_LEASES, PERFORM_COMMAND, RELEASE_LEASE, RENEW_LEASE
from homebot.devices.outcomes import Confirmed, Contradicted, NoAnswer, Refused
from homebot.devices.value import Value
from homebot.errors import RefusedError, UsageError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part

pytestmark = pytest.mark.virtual_time

LEASE_STEPS = frozenset({"held", "released", "ended", "expired", "outranked", "handed_back", "denied"})


@asynccontextmanager
async def a_door(
    open_home: OpenHome, *, hand_time: float = 300, retries: int = 2
) -> AsyncIterator[tuple[Home, Closure]]:
    """Open a home with a closed door."""
    async with open_home(always_ask=False, rate_limit=False, hand_time=hand_time, retries=retries) as home:
        yield home, await home.new(Closure, "door", "movement", "position", before={"movement": "closed"})


def request(door: Closure, *, value: str = "open", by: str = "robot", ttl: float = 10, lease: str = "1") -> HoldRequest:
    scope = ("act: closure",)
    return hold_request(door.device.id, "movement", value, by=by, ttl=ttl, lease=lease, scope=scope)


async def end(home: Home, door: Closure) -> tuple[HeldPart, ...]:
    """End the leases of the door as a person does."""
    client = home.app.create_client(EndLeases, END_LEASES)
    return (await client.call(EndLeases.Request(device=door.device.id, issuer="client:owner"))).parts


async def steps(home: Home) -> list[JournalEntry]:
    """Return the entries of leases."""
    return [one for one in (await home.read()).entries if one.kind in LEASE_STEPS]


def told(entries: list[JournalEntry]) -> list[tuple[str, str, str]]:
    return [(one.kind, one.issuer, one.text) for one in entries]


@pytest.mark.filterwarnings("default")
async def test_a_hold_without_a_block_is_a_warning_as_a_forgotten_await_is(open_home: OpenHome) -> None:
    """It held nothing, and nobody said so. The warning comes at once, so that it names the line."""
    async with a_door(open_home) as (home, door):
        with pytest.warns(RuntimeWarning, match=r"coroutine 'Handle\.hold\.__aenter__' was never awaited") as seen:
            door.hold("open", by="robot")
        assert [one.filename for one in seen] == [__file__]
        assert await home.leases() == ()


async def test_a_door_is_opened_and_a_close_of_another_is_refused_while_it_is_held(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        async with door.hold("open", by="robot", ttl=10) as held:
            assert isinstance(held.outcome, Confirmed)
            assert held.succeeded
            await anyio.sleep(2)
            refused = await door.close()
            assert isinstance(refused, Refused)
            assert (refused.policy, refused.reason) == ("lease", "held open by robot for 8 s more")
            assert isinstance(await door.set_position(30), Refused)
            assert [one.value.plain() for one in home.commands] == ["open"]
        assert not held.is_held
        assert (await door.close()).succeeded


async def test_a_setpoint_that_is_held_is_not_changed_by_as_much_as_a_device_may_round(home: Home) -> None:
    radiator = await home.new(Thermostat, "radiator", "heating_setpoint")
    async with radiator.hold("21", by="robot", ttl=10) as held:
        assert held.succeeded
        assert isinstance(await radiator.heat_to(21.5), Refused)
        assert not isinstance(await radiator.heat_to(21.0), Refused)


async def test_the_steps_of_a_dimmer_are_no_hand(home: Home) -> None:

    async def round_it(home: Home, command: Command) -> None:
        value = command.value.plain()
        assert isinstance(value, float)
        await home.report("lamp", "level", 5.0 * round(value / 5.0))

    lamp = await home.lamp("on_off", "level", behaviour=round_it)
    for level in (62.0, 33.0, 47.0):  # from these it is learnt
        assert isinstance(await lamp.set_level(level), Contradicted)
    async with lamp.hold("0.88", by="robot", ttl=10) as holding:
        assert isinstance(holding.outcome, Confirmed)
        await home.report("lamp", "level", 90.0)
        await anyio.sleep(5)
        assert (holding.is_held, isinstance(holding.outcome, Confirmed)) == (True, True)
        await home.report("lamp", "level", 70.0)
        await anyio.sleep(5)
        assert isinstance(holding.outcome, Contradicted)


async def test_each_command_of_a_lease_has_the_transition_of_its_holder(open_home: OpenHome) -> None:
    async with open_home(hand_time=20) as home:
        await home.lamp("on_off", before={"on_off": False})
        await home.hold(hold_request("lamp", "on_off", True, scope=("act: light",), ttl=100, transition=0.1))
        await anyio.sleep(20)
        await home.report("lamp", "on_off", False)
        await anyio.sleep(30)
        assert [(one.value.flag, one.transition) for one in home.commands] == [(True, 0.1), (True, 0.1)]


@pytest.mark.parametrize(("later", "is_so"), [((2.0, 80.0), True), ((2.0, 60.0), False)])
async def test_steps_after_the_end_was_reported_are_a_hand_only_if_the_lamp_stays_there(
    home: Home, later: tuple[float, float], *, is_so: bool
) -> None:
    lamp = await home.lamp(
        "on_off", "level", before={"level": 20.0}, behaviour=report((0.05, 80.0), (1.0, 50.0), later)
    )
    async with lamp.hold("0.8", by="robot", ttl=10) as holding:
        await anyio.sleep(5)
        assert isinstance(holding.outcome, Confirmed)
        await anyio.sleep(15)
        assert isinstance(holding.outcome, Confirmed if is_so else Contradicted)


async def test_a_command_for_the_same_and_a_stop_pass(open_home: OpenHome) -> None:
    async with a_door(open_home, hand_time=20) as (home, door), door.hold("open", by="robot"):
        assert (await door.open()).succeeded
        home.behaviours["door"] = report((1.0, "stopped"))
        home.tasks.start_soon(home.report, "door", "movement", "opening")
        await anyio.sleep(0.1)
        assert not isinstance(await door.stop(), Refused)
        assert told(await steps(home))[1:] == [("outranked", "", "it was stopped")]
        del home.behaviours["door"]
        assert home.commands[-1].value.plain() == "stopped"
        await anyio.sleep(15)
        assert home.commands[-1].value.plain() == "stopped"
        await anyio.sleep(10)
        assert home.commands[-1].value.plain() == "open"


async def test_a_second_holder_joins_and_the_door_is_free_when_both_have_left(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        async with door.hold("open", by="robot"):
            async with door.hold("open", by="vacuum") as second:
                assert second.succeeded
                assert "held open by robot, vacuum" in await refusal(door.close())
            assert isinstance(await door.close(), Refused)
        assert (await door.close()).succeeded
        assert len(home.commands) == 2


async def test_two_who_begin_at_once_do_not_supersede_each_other(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        home.behaviours["door"] = obey_after(1)
        succeeded: list[bool] = []

        async def pass_through(by: str) -> None:
            async with door.hold("open", by=by) as held:
                succeeded.append(held.succeeded)

        async with anyio.create_task_group() as tasks:
            tasks.start_soon(pass_through, "robot")
            tasks.start_soon(pass_through, "vacuum")
        assert succeeded == [True, True]


async def test_who_wants_another_value_is_refused_and_its_block_holds_nothing(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot"):
        async with door.hold("close", by="guard") as other:
            assert isinstance(other.outcome, Refused)
            assert not other.is_held
            await anyio.sleep(60)
        assert [one.value.plain() for one in home.commands] == ["open"]
        entry = (await steps(home))[1]
    assert (entry.kind, entry.text, entry.issuer) == ("denied", "guard", "/app")
    assert (entry.verdicts[0].policy, entry.verdicts[0].reason) == ("lease", "held open by robot for 10 s more")
    assert entry.settings[0].value.plain() == "closed"


async def test_a_block_holds_for_longer_than_its_ttl_and_no_renewal_is_in_the_journal(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        async with door.hold("open", by="robot", ttl=1) as held:
            await anyio.sleep(600)
            assert held.succeeded
            assert isinstance(await door.close(), Refused)
            assert len(home.commands) == 1
        found = await steps(home)
    assert told(found) == [("held", "/app", "robot"), ("released", "/app", "robot")]
    assert [(one.device, one.settings) for one in found] == [(door.device.id, (Setting.of("movement", "open"),))] * 2


async def test_a_door_that_opens_slower_than_the_ttl_is_held_meanwhile(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        home.behaviours["door"] = report((0.1, "opening"), (15.0, "open"))
        async with door.hold("open", by="robot", ttl=3) as held:
            assert held.succeeded


async def test_a_holder_that_died_blocks_no_longer_than_its_ttl(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        assert (await home.hold(request(door))).held
        await anyio.sleep(9.9)
        assert isinstance(await door.close(), Refused)
        await anyio.sleep(0.2)
        assert told(await steps(home)) == [("held", "client:robot", "robot"), ("expired", "client:robot", "robot")]
        assert (await door.close()).succeeded


async def test_two_holders_whose_time_is_over_at_once_are_both_released(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        await home.report("door", "movement", "open")
        async with anyio.create_task_group() as tasks:
            for name in ("1", "2"):
                tasks.start_soon(home.hold, request(door, lease=name))
        await anyio.sleep(10.1)
        assert (await door.close()).succeeded


async def test_a_block_that_is_cancelled_while_it_begins_holds_nothing(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        home.behaviours["door"] = obey_after(5)
        with anyio.move_on_after(1):
            async with door.hold("open", by="robot", ttl=3600):
                pytest.fail("it was not open yet")
        assert not isinstance(await door.close(), Refused)


async def test_an_error_in_the_block_comes_out_as_itself(open_home: OpenHome) -> None:
    async with a_door(open_home) as (_, door):
        with pytest.raises(ValueError, match="lost the way"):
            async with door.hold("open", by="robot"):
                raise ValueError("lost the way")
        assert (await door.close()).succeeded


async def test_a_hand_outranks_the_holder_and_is_then_handed_back(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot", ttl=9) as held:
        await anyio.sleep(20)
        await home.report("door", "movement", "closed")
        await anyio.sleep(3.1)
        assert isinstance(held.outcome, Contradicted)
        assert held.is_held
        assert held.outcome.saw == "movement is closed; it is commanded again in 299 s"
        await anyio.sleep(295)
        assert len(home.commands) == 1
        assert told(await steps(home))[1:] == [("outranked", "", "movement is closed")]
        await anyio.sleep(6)
        assert [one.kind for one in await steps(home)] == ["held", "outranked", "handed_back"]
        assert [one.value.plain() for one in home.commands] == ["open", "open"]
        assert held.succeeded


async def test_a_person_overrides_a_lease_by_saying_so_and_the_holder_is_told(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot", ttl=9) as held:
        words = {"target": "door", "command": "close", "issuer": "client:phone", "scope": ("act: closure",)}
        client = home.app.create_client(CommandDevices, COMMAND_DEVICES)
        refused = await client.call(CommandDevicesRequest.model_validate(words), timeout=900)
        assert "held open by robot" in refused.results[0].result.text
        app = await door.command("movement", "closed")
        assert isinstance(app, Refused)
        obeyed = await client.call(CommandDevicesRequest.model_validate({**words, "override": True}), timeout=900)
        assert obeyed.success, obeyed
        await anyio.sleep(4)
        assert isinstance(held.outcome, Contradicted)
        assert held.outcome.saw.startswith("the client phone overrode it; it is commanded again in 29")
        assert told(await steps(home))[-1:] == [("outranked", "", "the client phone overrode it")]
        await anyio.sleep(300)
        assert [one.value.plain() for one in home.commands] == ["open", "closed", "open"]


@pytest.mark.parametrize("payload", ["closed", '{"state": "CLOSE"}'])
async def test_a_raw_command_of_another_program_is_a_hand(open_home: OpenHome, payload: str) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot") as held:
        await anyio.sleep(20)
        home.behaviours["door"] = ignore
        out = home.app.create_publisher(RawCommand, GatewayNames("memory").out)
        out.publish(RawCommand(address=door.device.endpoints[0].command_address, payload=payload))
        await anyio.sleep(1)
        await home.report("door", "movement", "closed")
        await anyio.sleep(4)  # until it is renewed
        assert isinstance(held.outcome, Contradicted)
        assert told(await steps(home))[1:] == [("outranked", "", "movement is closed")]


async def test_a_hand_is_seen_when_all_facts_of_the_part_are_older_than_the_timeline_keeps(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot") as held:
        await anyio.sleep(2 * REMEMBERED)
        await home.report("door", "position", 100.0)  # which drops the older facts
        await home.report("door", "movement", "opening")
        assert held.succeeded
        await home.report("door", "movement", "closed")
        await anyio.sleep(4)  # until it is renewed
        assert isinstance(held.outcome, Contradicted)


async def test_after_a_hand_nothing_is_commanded_for_a_holder_that_left(open_home: OpenHome) -> None:
    async with a_door(open_home, hand_time=30) as (home, door):
        async with door.hold("open", by="robot"):
            await anyio.sleep(20)
            await home.report("door", "movement", "closed")
            await anyio.sleep(1)
        await anyio.sleep(600)
        assert len(home.commands) == 1


async def test_a_hand_that_opens_it_again_ends_the_wait(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot") as held:
        await anyio.sleep(20)
        await home.report("door", "movement", "closed")
        await home.report("door", "movement", "open")
        await anyio.sleep(400)
        assert held.succeeded
        assert len(home.commands) == 1
        assert [one.kind for one in await steps(home)] == ["held", "outranked", "handed_back"]


async def test_a_door_that_did_not_hear_is_told_again_while_it_is_held(open_home: OpenHome) -> None:
    async with a_door(open_home, retries=0) as (home, door):
        home.behaviours["door"] = ignore
        async with door.hold("open", by="robot") as held:
            assert isinstance(held.outcome, NoAnswer)
            del home.behaviours["door"]
            await anyio.sleep(40)
            assert held.succeeded
            assert len(home.commands) == 2


async def test_a_close_that_is_on_its_way_is_not_repeated_once_the_door_is_held(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        await home.report("door", "movement", "open")
        await anyio.sleep(70)
        home.behaviours["door"] = ignore
        home.tasks.start_soon(door.set_position, 0.0)
        await anyio.sleep(1)
        async with door.hold("open", by="robot"):
            await anyio.sleep(60)
        assert [one.value.plain() for one in home.commands[:2]] == [0.0, "open"]
        assert all(one.value.plain() == "open" for one in home.commands[1:])


async def test_a_dimmed_lamp_is_on_and_dark_is_off(home: Home) -> None:
    lamp = await home.lamp("on_off", "level")
    async with lamp.hold("on", by="cook"):
        assert not isinstance(await lamp.set_level(30), Refused)
        assert isinstance(await lamp.set_level(0), Refused)
        assert (await refusal(lamp.turn_off())).startswith("held on by cook for ")


async def test_a_refusal_tells_the_held_number_with_its_unit(home: Home) -> None:
    lamp = await home.lamp("on_off", "level")
    async with lamp.hold("0.4", by="cook"):
        assert (await refusal(lamp.set_level(90))).startswith("held at 40 % by cook for ")


async def test_a_lamp_that_is_held_dark_takes_no_colour_and_one_that_is_held_on_does(home: Home) -> None:
    lamp = await home.lamp("on_off", "color_temperature")
    async with lamp.hold("off", by="cinema"):
        assert isinstance(await lamp.turn_on(kelvin=2700), Refused)
    async with lamp.hold("on", by="cook"):
        assert isinstance(await lamp.turn_on(kelvin=2700), Confirmed)


async def test_a_refusal_by_the_device_is_no_hand_and_the_value_is_commanded_again(home: Home) -> None:
    answers = home.gateway.node.create_publisher(CommandAnswer, home.gateway.names.answers, 10)

    async def refuse(_home: Home, command: Command) -> None:
        given = {"key": command.key, "part": command.part, "capability": command.capability, "command_id": command.id}
        answers.publish(CommandAnswer(gateway="memory", success=False, message="it is too hot", **given))

    lamp = await home.lamp("on_off", behaviour=refuse)
    async with lamp.hold("on", by="robot", ttl=9) as held:
        assert isinstance(held.outcome, Contradicted)
        (part,) = await home.leases()
        assert part.saw == ""
        home.behaviours["lamp"] = obey
        await anyio.sleep(31)
        assert (len(home.commands), lamp.on) == (2, True)


async def test_the_brightness_of_a_lamp_that_is_held_dark_is_no_hand(home: Home) -> None:
    home.put("lamp", "light", "on_off", "level")

    async def be_off(home: Home, _command: Command) -> None:
        await home.report("lamp", "on_off", False)
        await home.report("lamp", "level", 100.0)

    home.behaviours["lamp"] = be_off
    assert (await home.hold(hold_request("lamp", "level", 0.0, "/cinema"))).held
    await home.report("lamp", "level", 90.0)
    (held,) = await home.leases()
    assert (held.setting.capability, held.saw) == ("on_off", "")
    await anyio.sleep(1)  # of virtual time, so that it does not fade
    await home.report("lamp", "on_off", True)
    await anyio.sleep(1)
    (held,) = await home.leases()
    assert held.saw == "on_off is on"


@pytest.mark.parametrize(
    ("device", "part", "problem"),
    [
        ("lampe", "", "there is no device with the id lampe"),
        ("lamp", "main", "lamp has no part main; it has one part without an id"),
    ],
)
async def test_who_holds_or_commands_what_is_not_there_is_told_what_is(
    home: Home, device: str, part: str, problem: str
) -> None:
    home.put("lamp", "light", "on_off")
    await anyio.sleep(0.1)
    lit = Setting(capability="on_off", value=Value.of(True))
    answer = await home.hold(hold_request(device, "on_off", True, part=part))
    assert (answer.held, answer.result.outcome, answer.result.text) == (False, "gone", problem)
    command = CommandRequest(device=device, part=part, settings=(lit,), issuer="client:cook")
    result = await home.app.create_client(PerformCommand, PERFORM_COMMAND).call(command)
    assert (result.kind, result.text) == ("gone", problem)


async def test_who_holds_one_of_two_devices_of_a_name_is_asked_which(home: Home) -> None:
    for key in ("one", "other"):
        home.put(key, "light", "on_off", name="Big twin")
    await anyio.sleep(0.1)
    answer = await home.hold(hold_request("big twin", "on_off", True))
    assert not answer.held
    assert answer.result.text.startswith("2 devices are called big twin; give the id of one: big_twin")


async def test_the_log_names_the_program_that_holds_nothing_beside_the_name_it_gives_itself(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    await anyio.sleep(0.1)
    assert (await home.hold(hold_request("lamp", "on_off", True))).held
    with capture_logs() as lines:
        assert not (await home.hold(hold_request("lamp", "on_off", False, "client:agent"))).held
    assert "lamp is not held for robot (client:agent): held on by robot" in lines[0]["message"]


@pytest.mark.parametrize(
    ("relays", "answer"),
    [
        (("relay",), (True, "no_answer")),
        (("left", "right"), (False, "gone")),
    ],
)
async def test_a_part_is_named_only_where_several_take_what_is_held_or_commanded(
    home: Home, relays: tuple[str, ...], answer: tuple[bool, str]
) -> None:
    """A child lock, which is a setting, is not what is meant by a plug."""
    switch = simple_part("switch", settable=("on_off",))
    lock = simple_part("x_setting", settable=("on_off",)).model_copy(update={"id": "lock", "category": "config"})
    parts = (lock, *(switch.model_copy(update={"id": name}) for name in relays))
    home.gateway.devices.put(GatewayDevice("plug", "Plug", parts), "the test says so")
    home.behaviours["plug"] = ignore
    await anyio.sleep(0.1)
    lit = Setting(capability="on_off", value=Value.of(True))
    held = await home.hold(hold_request("plug", "on_off", True, "/cook", ttl=60))
    assert (held.held, held.result.outcome) == answer
    assert [one.part for one in home.commands] == ["relay"] * 3 * held.held
    assert ("no single part of plug takes that; it has lock, left, right" in held.result.text) is not held.held
    command = CommandRequest(device="plug", settings=(lit,), issuer="/cook")
    result = await home.app.create_client(PerformCommand, PERFORM_COMMAND).call(command, timeout=600)
    assert (result.kind, result.text) == (held.result.outcome, held.result.text)
    assert [one.part for one in home.commands] == ["relay"] * 6 * held.held
    journal = await home.read(device="plug")
    assert {one.part for one in journal.entries} == {"relay" if held.held else ""}


@pytest.mark.parametrize(("word", "by", "ttl"), [("open", "", 10), ("open", "  ", 10), ("open", "robot", 0.5)])
async def test_a_holder_without_a_name_or_with_a_bad_ttl_is_an_error(
    open_home: OpenHome, word: str, by: str, ttl: float
) -> None:
    async with a_door(open_home) as (home, door):
        with pytest.raises(UsageError):
            async with door.hold(word, by=by, ttl=ttl):
                pytest.fail("nothing is held")
        assert home.commands == []


@pytest.mark.parametrize("word", ["stop", "boil"])
async def test_what_does_not_last_or_is_not_understood_cannot_be_held(open_home: OpenHome, word: str) -> None:
    async with a_door(open_home) as (_, door):
        with pytest.raises(RefusedError):
            async with door.hold(word, by="robot"):
                pytest.fail("nothing is held")


async def test_a_client_without_a_name_or_a_right_blocks_nobody(open_home: OpenHome) -> None:
    async with open_home(always_ask=False) as home:
        home.put("lock", "door_lock", "lock")
        door = await home.new(Closure, "door", "movement")
        blank = await home.hold(request(door, by=" "))
        assert (blank.held, blank.result.policy) == (False, "lease")
        lock = await home.handle(DoorLock, "lock")
        wanted = Setting(capability="lock", value=Value.of("unlocked"))
        refused = await home.hold(request(door).model_copy(update={"device": lock.device.id, "setting": wanted}))
        assert (refused.held, refused.result.policy) == (False, "rights")
        assert (await door.close()).succeeded
        assert (await lock.unlock()).succeeded


def test_the_border_takes_no_lease_without_a_name_or_without_an_end() -> None:
    fields = {"device": "d", "setting": {"capability": "movement", "value": {}}, "lease": "1", "issuer": "/app"}
    for wrong in ({"by": "", "ttl": 10}, {"by": "r", "ttl": 3601}, {"by": "r", "ttl": 0}, {"by": "r", "ttl": "nan"}):
        with pytest.raises(ValueError, match=r"by|ttl"):
            HoldRequest.model_validate({**fields, **wrong})


def begin(leases: Leases, issuer: str, name: int) -> Lease | str:
    """Hold the lock for an hour from 0 s on."""
    return leases.hold(("d", ""), "lock", "locked", (issuer, "r", str(name)), LeaseHolder("r", 3600, 3600), 0)


def test_further_holders_are_refused_and_counted() -> None:
    leases = Leases(300)
    for number in range(MAX_HOLDERS):
        assert not isinstance(begin(leases, f"client:{number % 20}", number), str)
    assert begin(leases, "client:late", 0) == "there are 1,000 holders already"
    assert leases.refused == 1
    assert len(leases.expire(3600)) == MAX_HOLDERS
    assert list(leases) == []


def test_one_issuer_has_fifty_leases_at_most_and_the_others_have_room() -> None:
    leases = Leases(300)
    for number in range(MAX_HOLDERS_OF_ISSUER):
        assert not isinstance(begin(leases, "client:greedy", number), str)
    assert begin(leases, "client:greedy", 50) == "client:greedy has 50 leases already; release one first"
    assert leases.refused == 1
    assert not isinstance(begin(leases, "client:honest", 0), str)
    leases.release(("client:greedy", "r", "7"))
    assert not isinstance(begin(leases, "client:greedy", 50), str)


async def test_a_person_ends_a_lease_and_its_block_does_not_get_it_again(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door), door.hold("open", by="robot", ttl=6) as held:
        (part,) = await end(home, door)
        assert [(one.by, one.issuer) for one in part.holders] == [("robot", "/app")]
        assert (await door.close()).succeeded
        await anyio.sleep(60)
        assert not held.is_held
        assert isinstance(held.outcome, Refused)
        assert held.outcome.reason == "its lease was ended by client:owner"
        assert [one.value.plain() for one in home.commands] == ["open", "closed"]
        assert await end(home, door) == ()
        assert told(await steps(home))[1:] == [("ended", "client:owner", "robot"), ("denied", "/app", "robot")]


async def test_who_holds_again_under_another_name_may(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        assert (await home.hold(request(door))).held
        await end(home, door)
        assert not (await home.hold(request(door))).held
        assert (await home.hold(request(door, lease="2"))).held
        await end(home, door)
        await anyio.sleep(11)
        assert (await home.hold(request(door))).held


async def test_all_holders_of_a_device_are_ended_and_no_others(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        lamp = await home.lamp("on_off")
        async with lamp.hold("on", by="cook"), door.hold("open", by="robot"), door.hold("open", by="vacuum"):
            (part,) = await end(home, door)
            assert [one.by for one in part.holders] == ["robot", "vacuum"]
            assert isinstance(await lamp.turn_off(), Refused)
            assert (await door.close()).succeeded


async def test_who_holds_what_until_when_is_told(open_home: OpenHome) -> None:
    async with a_door(open_home, hand_time=30) as (home, door):
        assert await home.leases() == ()
        async with door.hold("open", by="robot", ttl=9):
            now = home.graph.clock.now()
            (part,) = await home.leases(door.device.id)
            assert (part.device, part.setting.value.plain(), part.saw) == (door.device.id, "open", "")
            assert part.outranked_until.to_seconds() == 0
            assert [round(one.until.to_seconds() - now) for one in part.holders] == [9]
            await anyio.sleep(20)
            await home.report("door", "movement", "closed")
            await anyio.sleep(0.1)
            (part,) = await home.leases()
            assert part.saw == "movement is closed"
            assert round(part.outranked_until.to_seconds() - now) == 50
            assert await home.leases("another") == ()


async def test_who_may_not_hold_does_not_block_while_somebody_else_is_commanding(open_home: OpenHome) -> None:
    """Neither alone nor when the one before it, for whose command it would wait, has left."""
    async with a_door(open_home) as (home, door):
        home.behaviours["door"] = ignore
        home.tasks.start_soon(home.hold, request(door, ttl=1))
        await anyio.sleep(0.1)
        for wanted in nobodies(door, "2"):
            assert not (await home.hold(wanted)).held
        await anyio.sleep(1)
        assert await home.leases() == ()
        home.behaviours["door"] = obey_after(0.1)
        assert not isinstance(await door.close(), Refused)


async def test_who_renews_or_releases_what_it_does_not_hold_changes_nothing(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        stranger = HolderRequest(lease="1", by="robot", issuer="client:tv")
        renew = home.app.create_client(RenewLease, RENEW_LEASE)
        assert not (await renew.call(stranger)).held
        assert (await door.close()).succeeded
        assert (await home.hold(request(door))).held
        assert not (await renew.call(stranger)).held
        await home.app.create_client(ReleaseLease, RELEASE_LEASE).call(stranger)
        assert isinstance(await door.close(), Refused)


async def test_who_releases_hears_what_became_of_the_newest_command(open_home: OpenHome) -> None:
    async with a_door(open_home) as (home, door):
        assert (await home.hold(request(door))).held
        release = home.app.create_client(ReleaseLease, RELEASE_LEASE)
        mine = HolderRequest(lease="1", by="robot", issuer="client:robot")
        answers = [await release.call(mine) for _ in range(2)]
        assert [one.held for one in answers] == [False, False]
        assert [one.outcome.kind for one in answers] == ["confirmed", "refused"]


def test_of_those_whose_leases_were_ended_the_newest_are_remembered() -> None:
    leases = Leases(300)

    for number in range(MAX_HOLDERS + 1):
        assert not isinstance(begin(leases, "", number), str)
        leases.end("d", "client:owner", 0)
    assert begin(leases, "", 1) == "its lease was ended by client:owner"
    assert not isinstance(begin(leases, "", 0), str)


STEPS = st.lists(
    st.tuples(
        st.sampled_from(
            ["first", "second", "leave first", "leave second", "killed", "close", "lower", "hand", "deaf", "nobody"]
        ),
        st.floats(0.0, 12.0),
    ),
    max_size=14,
)


def nobodies(door: Closure, lease: str) -> tuple[HoldRequest, ...]:
    """Requests of a holder without a name, and of clients without the right."""
    wanted = request(door, ttl=3600, lease=lease)
    return (
        wanted.model_copy(update={"by": "  "}),
        wanted.model_copy(update={"issuer": "client:tv", "scope": ("read",)}),
        wanted.model_copy(update={"issuer": "client:lamps", "scope": ("act: light",)}),
    )


class Doorway:
    """A door, two robots that pass it, programs that hold it and are killed, and people.

    Attributes:
        closed_on: The commands to close that reached the door while somebody held it.
        is_deaf: Whether the door hears nothing.
    """

    def __init__(self, home: Home, door: Closure, delay: float) -> None:
        self.closed_on: list[Command] = []
        self.is_deaf = False
        self._home = home
        self._door = door
        self._delay = delay
        self._inside: set[str] = set()
        self._leaving: dict[str, anyio.Event] = {}
        self._held_until = 0.0
        home.behaviours["door"] = self._obey

    async def step(self, step: str, number: int) -> None:
        """Let one thing happen."""
        match step.split():
            case ["leave", robot]:
                self._leave(robot)
            case ["killed"]:
                self._home.tasks.start_soon(self._die, request(self._door, ttl=5, lease=str(number)))
            case ["close"]:
                self._home.tasks.start_soon(self._door.close)
            case ["lower"]:
                self._home.tasks.start_soon(self._door.set_position, 0.0)
            case ["nobody"]:
                for wanted in nobodies(self._door, str(number)):
                    self._home.tasks.start_soon(self._refuse, wanted)
            case ["hand"]:
                await self._home.report("door", "movement", "closed")
            case ["deaf"]:
                self.is_deaf = not self.is_deaf
            case [robot] if robot not in self._leaving:
                self._leaving[robot] = anyio.Event()
                self._home.tasks.start_soon(self._pass, robot, self._leaving[robot])

    async def empty(self) -> None:
        """Let everybody leave, and wait for longer than any command takes."""
        for robot in tuple(self._leaving):
            self._leave(robot)
        await anyio.sleep(400)

    def _leave(self, robot: str) -> None:
        if robot in self._leaving:
            self._leaving.pop(robot).set()

    async def _pass(self, robot: str, leave: anyio.Event) -> None:
        async with self._door.hold("open", by=robot, ttl=6) as held:
            if held.is_held:
                self._inside.add(robot)
            await leave.wait()
            self._inside.discard(robot)

    async def _die(self, wanted: HoldRequest) -> None:
        began = anyio.current_time()
        if (await self._home.hold(wanted)).held:
            self._held_until = max(self._held_until, began + wanted.ttl)

    async def _refuse(self, wanted: HoldRequest) -> None:
        assert not (await self._home.hold(wanted)).held

    async def _obey(self, home: Home, command: Command) -> None:
        is_held = self._inside or anyio.current_time() < self._held_until
        if is_held and command.value.plain() in {"closed", 0.0}:
            self.closed_on.append(command)
        if not self.is_deaf:
            home.later(self._delay, command.key, command.capability, command.value.plain())


@settings(max_examples=examples(250), suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow])
@given(STEPS, st.floats(0.0, 3.0))
async def test_the_door_never_closes_on_a_holder_and_is_free_after_the_last_ttl(
    open_home: OpenHome, steps: list[tuple[str, float]], delay: float
) -> None:
    """Two robots, somebody who wants it closed, a hand, a holder that is killed, and those who may hold nothing."""
    async with a_door(open_home, hand_time=20) as (home, door):
        doorway = Doorway(home, door, delay)
        for number, (step, seconds) in enumerate(steps):
            await doorway.step(step, number)
            await anyio.sleep(seconds)
        await doorway.empty()
        assert doorway.closed_on == []
        doorway.is_deaf = False
        await home.report("door", "movement", "open")
        await anyio.sleep(70)
        assert (await door.close()).succeeded
        assert (await door.set_position(50)).succeeded
