"""Commands given at once to the members of a group: one message, and a proof of each; in virtual time."""

from collections.abc import Mapping

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, OpenHome, answer_requests, hold_request, ignore
from tests.control.test_explanations import explain

from homebot.apps import App
from homebot.apps.base import NoSettings
from homebot.devices.batch import perform_all
from homebot.devices.command_messages import (
    CommandDevices,
    CommandDevicesRequest,
    CommandRequest,
    PerformCommand,
    Setting,
)
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.names import COMMAND_DEVICES, PERFORM_COMMAND
from homebot.devices.outcomes import AlreadySo, Confirmed, Evidence, NoAnswer, Outcome, Refused
from homebot.devices.value import PlainValue
from homebot.devices.wording.journal_words import entry_text
from homebot.errors import LinkError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part

pytestmark = pytest.mark.virtual_time

LAMPS = ("one", "two", "three")
ON = {"on_off": True}


async def put_lamps(
    home: Home,
    *members: str,
    settable: tuple[str, ...] = ("on_off", "level"),
    echoed: bool = False,
    **before: PlainValue,
) -> None:
    """Put three lamps that are off, and a group of *members*, by default all, whose lamps report after 0.2 s."""
    for name in LAMPS:
        _put(home, name, ("on_off", "level"))
    _put(home, "group", settable, *(f"id:{one}" for one in members or LAMPS), echoed=echoed)
    for name in LAMPS:
        await home.report(name, "on_off", before.get(name, False))
    await anyio.sleep(1.0)
    home.behaviours["group"] = tell_members


def _put(home: Home, key: str, settable: tuple[str, ...], *members: str, echoed: bool = False) -> None:
    part = simple_part("light", settable=settable).model_copy(update={"members": members})
    part = part.model_copy(
        update={"capabilities": tuple(one.model_copy(update={"echoed": echoed}) for one in part.capabilities)}
    )
    home.gateway.devices.put(GatewayDevice(key, key.title(), (part,), identifiers=(f"id:{key}",)), "it was found")


async def tell_members(home: Home, command: Command) -> None:
    """Let all lamps do what their group is told."""
    for name in ("group", *LAMPS):
        home.later(0.2, name, command.capability, command.value.plain())


def lose(*deaf: str) -> Behaviour:
    """Return a group whose message does not reach some lamps."""

    async def tell(home: Home, command: Command) -> None:
        for name in set(LAMPS) - set(deaf):
            home.later(0.2, name, command.capability, command.value.plain())

    return tell


async def command(home: Home, settings: Mapping[str, PlainValue] = ON, *names: str, **more: object) -> list[Outcome]:
    """Command the lamps at once."""
    wanted = tuple(Setting.of(name, value) for name, value in settings.items())
    client = home.app.create_client(PerformCommand, PERFORM_COMMAND)
    requests = [
        CommandRequest.model_validate({"device": one, "settings": wanted, "issuer": "/app", **more})
        for one in names or LAMPS
    ]

    async def perform(request: CommandRequest) -> Outcome:
        return await client.call(request, timeout=900)

    return await perform_all(perform, requests)


def keys(home: Home) -> list[str]:
    return [one.key for one in home.commands]


async def causes(home: Home) -> dict[str, list[str]]:
    """Return the causes of all changes that the journal tells, by device."""
    await anyio.sleep(20)
    found: dict[str, list[str]] = {}
    for one in (await home.read()).entries:
        if one.kind in {"changed", "reported"}:
            found.setdefault(one.device, []).append(one.cause)
    return found


async def test_the_members_of_a_group_are_told_by_one_message_and_each_proves_it(home: Home) -> None:
    await put_lamps(home)
    outcomes = await command(home)
    assert keys(home) == ["group"]
    assert [(type(one), one.reported) for one in outcomes] == [(Confirmed, {"on_off": True})] * 3
    assert await causes(home) == {name: ["command"] for name in LAMPS}


async def test_why_says_that_a_command_went_to_the_group(home: Home) -> None:
    await put_lamps(home)
    await command(home)
    sent = [one for one in (await explain(home, "two")).entries if one.kind == "sent"]
    assert [entry_text(one, {}) for one in sent] == ["handed to the gateway in one message to the group Group"]


async def test_a_lamp_that_missed_the_message_is_told_by_itself(home: Home) -> None:
    await put_lamps(home)
    home.behaviours["group"] = lose("two")
    outcomes = await command(home)
    assert keys(home) == ["group", "two"]
    assert [type(one) for one in outcomes] == [Confirmed] * 3


async def test_a_lamp_that_misses_each_message_is_told_by_itself_as_soon_as_the_first_time(home: Home) -> None:
    await put_lamps(home)
    home.behaviours["group"] = lose("two")
    taken: list[float] = []
    for number in range(8):
        outcomes = await command(home, {"on_off": number % 2 == 0})
        taken += [one.latency for one in outcomes[1:2] if isinstance(one, Confirmed)]
        await anyio.sleep(60)
    assert len(taken) == 8
    assert max(taken) == taken[0]


async def test_a_lamp_that_is_dead_is_the_only_one_without_an_answer(home: Home) -> None:
    await put_lamps(home)
    home.behaviours["group"], home.behaviours["two"] = lose("two"), ignore
    assert [type(one) for one in await command(home)] == [Confirmed, NoAnswer, Confirmed]


async def test_what_a_bridge_says_of_its_group_is_no_proof_that_a_lamp_obeyed(home: Home) -> None:
    await put_lamps(home, echoed=True)

    async def repeat(home: Home, command: Command) -> None:
        for name in ("group", *LAMPS):
            home.later(0.01, name, command.capability, command.value.plain())
        await lose("two")(home, command)

    home.behaviours["group"] = repeat
    outcomes = await command(home)
    assert keys(home) == ["group", "two"]
    assert [type(one) for one in outcomes] == [Confirmed] * 3
    assert "person" not in {each for one in (await causes(home)).values() for each in one}


async def put_echoing_lamps(home: Home) -> None:
    """Put lamps whose bridge speaks for them after a message to their group, which reaches none of them."""
    await put_lamps(home, echoed=True)

    async def repeat(home: Home, command: Command) -> None:
        for name in LAMPS:
            home.later(0.01, name, command.capability, command.value.plain())

    home.behaviours["group"] = repeat


async def test_lamps_that_only_echo_and_cannot_be_asked_get_no_messages_of_their_own(home: Home) -> None:
    await put_echoing_lamps(home)
    outcomes = await command(home)
    assert keys(home) == ["group"]
    assert [one.evidence for one in outcomes if isinstance(one, Confirmed)] == [Evidence.ACKNOWLEDGED] * 3


async def test_lamps_are_asked_before_one_is_told_by_itself(home: Home) -> None:
    """The first has obeyed; the second answers that it has not, and is dead for further messages."""
    await put_echoing_lamps(home)
    home.behaviours["two"] = ignore

    async def answer(key: str) -> None:
        home.later(0.1, key, "on_off", key != "two")

    asked = answer_requests(home, answer)
    outcomes = await command(home)
    assert sorted(set(asked)) == sorted(LAMPS)
    assert set(keys(home)) == {"group", "two"}
    assert [type(one) for one in outcomes][::2] == [Confirmed] * 2
    assert not outcomes[1].succeeded


@pytest.mark.parametrize("tells_old_first", [False, True])
async def test_the_read_back_value_of_a_lamp_that_missed_it_has_it_told_by_itself(
    home: Home, *, tells_old_first: bool
) -> None:
    """Also if the lamp said what it was just before its bridge spoke for it."""
    await put_lamps(home, echoed=True)

    async def repeat(home: Home, command: Command) -> None:
        for name in LAMPS:
            if tells_old_first:
                home.later(0.005, name, command.capability, False)
            home.later(0.01, name, command.capability, command.value.plain())
            home.later(0.4, name, command.capability, name != "two")

    home.behaviours["group"] = repeat
    assert [type(one) for one in await command(home)] == [Confirmed] * 3
    assert keys(home) == ["group", "two"]
    assert "person" not in {each for one in (await causes(home)).values() for each in one}


async def test_what_is_so_already_needs_no_message_but_lets_the_others_share_one(home: Home) -> None:
    await put_lamps(home, one=True)
    assert [type(one) for one in await command(home)] == [AlreadySo, Confirmed, Confirmed]
    assert keys(home) == ["group"]


async def test_the_only_lamp_that_is_not_so_is_told_by_itself(home: Home) -> None:
    await put_lamps(home, one=True, two=True)
    await command(home)
    assert keys(home) == ["three"]
    sent = [one for one in (await explain(home, "three")).entries if one.kind == "sent"]
    assert [entry_text(one, {}) for one in sent] == ["handed to the gateway"]


@pytest.mark.parametrize(
    ("members", "named", "settings", "settable"),
    [
        (LAMPS[:2], LAMPS, ON, ("on_off",)),
        (LAMPS, LAMPS[:2], ON, ("on_off",)),
        ((*LAMPS, "unknown"), LAMPS, ON, ("on_off",)),
        (LAMPS, LAMPS, {"on_off": True, "level": 40.0}, ("on_off",)),
        (LAMPS, LAMPS, ON, ("level",)),
    ],
)
async def test_only_exactly_the_members_of_a_group_that_takes_the_values_share_a_message(
    home: Home,
    members: tuple[str, ...],
    named: tuple[str, ...],
    settings: Mapping[str, PlainValue],
    settable: tuple[str, ...],
) -> None:
    await put_lamps(home, *members, settable=settable)
    assert [type(one) for one in await command(home, settings, *named)] == [Confirmed] * len(named)
    assert sorted(set(keys(home))) == sorted(named)


async def test_several_settings_and_a_transition_go_to_the_group_in_their_order(home: Home) -> None:
    await put_lamps(home)
    await command(home, {"on_off": True, "level": 40.0}, transition=2.0)
    assert [(one.key, one.capability, one.transition) for one in home.commands] == [
        ("group", "level", 2.0),
        ("group", "on_off", 2.0),
    ]


async def test_a_command_by_itself_never_goes_to_a_group(home: Home) -> None:
    await put_lamps(home, "one")
    await (await home.handle(Light, "one")).turn_on()
    assert keys(home) == ["one"]


async def test_a_group_that_refuses_or_cannot_be_reached_leaves_each_to_itself_at_once(home: Home) -> None:
    await put_lamps(home)

    async def fail(_home: Home, _command: Command) -> None:
        raise LinkError("the bridge is away")

    home.behaviours["group"] = fail
    began = home.graph.clock.monotonic()
    assert [type(one) for one in await command(home)] == [Confirmed] * 3
    assert (keys(home)[0], *sorted(keys(home)[1:])) == ("group", *sorted(LAMPS))
    assert home.graph.clock.monotonic() - began < 0.1


async def test_a_held_member_is_kept_out_and_no_message_goes_to_the_group(home: Home) -> None:
    await put_lamps(home)
    await home.hold(hold_request("two", "on_off", False))
    home.commands.clear()
    outcomes = await command(home)
    assert [type(one) for one in outcomes] == [Confirmed, Refused, Confirmed]
    assert sorted(keys(home)) == ["one", "three"]


async def test_a_held_group_is_not_told_what_its_members_are(home: Home) -> None:
    await put_lamps(home)
    await home.hold(hold_request("group", "on_off", False))
    home.commands.clear()
    await command(home)
    assert "group" not in keys(home)


async def test_an_app_that_may_not_command_a_member_tells_the_others_by_themselves(open_home: OpenHome) -> None:
    async with open_home({"/app": ("act: id=one", "act: id=three")}) as home:
        await put_lamps(home)
        outcomes = await command(home)
        assert [type(one) for one in outcomes] == [Confirmed, Refused, Confirmed]
        assert sorted(keys(home)) == ["one", "three"]


async def test_an_app_that_may_command_all_members_needs_no_right_for_their_group(open_home: OpenHome) -> None:
    async with open_home({"/app": tuple(f"act: id={one}" for one in LAMPS)}) as home:
        await put_lamps(home)
        assert [type(one) for one in await command(home)] == [Confirmed] * 3
        assert keys(home) == ["group"]


async def test_a_right_to_a_group_of_a_gateway_is_one_to_its_members(open_home: OpenHome) -> None:
    async with open_home({"/app": ("act: group=Group",)}) as home:
        await put_lamps(home, "one", "two")
        outcomes = await command(home)
        assert [type(one) for one in outcomes] == [Confirmed, Confirmed, Refused]
        outcomes = await command(home, {"on_off": False}, "one", "two")
        assert [type(one) for one in outcomes] == [Confirmed, Confirmed]
        assert keys(home)[-1] == "group"


async def test_a_client_that_must_ask_for_one_member_tells_the_others_by_themselves(home: Home) -> None:
    await put_lamps(home)
    scope = ("act: id=one", "ask: id=two", "act: id=three")
    outcomes = await command(home, issuer="client:agent", scope=scope)
    assert [type(one) for one in outcomes] == [Confirmed, Refused, Confirmed]
    assert sorted(keys(home)) == ["one", "three"]


async def test_a_device_that_is_gone_leaves_the_others_to_themselves(home: Home) -> None:
    await put_lamps(home)
    outcomes = await command(home, ON, *LAMPS, "nothing")
    assert [one.succeeded for one in outcomes] == [True, True, True, False]
    assert sorted(keys(home)) == sorted(LAMPS)


async def test_the_lamps_of_a_query_are_told_by_one_message_and_the_group_is_no_target(home: Home) -> None:
    await put_lamps(home)
    words = home.app.create_client(CommandDevices, COMMAND_DEVICES)
    answer = await words.call(CommandDevicesRequest(target="lights", command="on"), timeout=60)
    assert keys(home) == ["group"]
    assert [one.device for one in answer.results] == sorted(LAMPS)
    assert answer.success


async def test_the_commands_of_an_app_to_each_of_its_lamps_share_one_message(home: Home) -> None:
    await put_lamps(home)
    found = [one for one in await home.devices.find(Light) if one.name != "Group"]
    outcomes: list[Outcome] = []

    class Evening(App):
        async def run(self) -> None:
            outcomes.extend(await self.each(Light.turn_on, found))

    async with anyio.create_task_group() as tasks:
        await tasks.start(Evening(home.app, NoSettings()).serve)
        await anyio.sleep(1)
        tasks.cancel_scope.cancel()
    assert keys(home) == ["group"]
    assert [type(one) for one in outcomes] == [Confirmed] * 3


async def test_two_batches_at_once_do_not_mix(home: Home) -> None:
    await put_lamps(home)
    async with anyio.create_task_group() as tasks:
        tasks.start_soon(command, home)
        tasks.start_soon(command, home, {"level": 40.0})
    assert sorted((one.key, one.capability) for one in home.commands) == [("group", "level"), ("group", "on_off")]


async def test_a_command_that_is_cancelled_while_it_waits_for_the_others_is_not_kept(home: Home) -> None:
    """A program that begins anew may give its batches the same names."""
    await put_lamps(home)
    client = home.app.create_client(PerformCommand, PERFORM_COMMAND)
    asked = {"settings": (Setting.of("on_off", True),), "issuer": "/app", "batch": "b", "batch_size": 3}
    one, *others = (CommandRequest.model_validate({"device": name, **asked}) for name in LAMPS)
    with anyio.move_on_after(0.1):
        await client.call(one, cancel_with_caller=True)
    async with anyio.create_task_group() as tasks:
        for request in (one, *others):
            tasks.start_soon(client.call, request)
    assert keys(home) == ["group"]


async def test_a_command_that_is_cancelled_before_it_is_sent_has_an_outcome_in_the_journal(home: Home) -> None:
    await put_lamps(home)
    request = CommandRequest(
        device="one", settings=(Setting.of("on_off", True),), issuer="/app", batch="b", batch_size=3
    )
    with anyio.move_on_after(0.1):
        await home.app.create_client(PerformCommand, PERFORM_COMMAND).call(request, cancel_with_caller=True)
    entries = (await home.read(device="one")).entries
    assert [(one.kind, [result.text for result in one.results]) for one in entries] == [
        ("requested", []),
        ("outcome", ["not sent: it was cancelled"]),
    ]


async def test_a_batch_with_different_commands_shares_a_message_for_those_that_are_alike(home: Home) -> None:
    await put_lamps(home)
    _put(home, "four", ("on_off",))
    client = home.app.create_client(PerformCommand, PERFORM_COMMAND)
    requests = [
        CommandRequest(device=one, settings=(Setting.of("on_off", one != "four"),), issuer="/app")
        for one in (*LAMPS, "four")
    ]

    async def perform(request: CommandRequest) -> Outcome:
        return await client.call(request, timeout=60)

    await perform_all(perform, requests)
    assert sorted(keys(home)) == ["four", "group"]


async def do(home: Home, target: str, word: str = "on") -> list[str]:
    """Command in words; return the devices that were commanded."""
    client = home.app.create_client(CommandDevices, COMMAND_DEVICES)
    answer = await client.call(CommandDevicesRequest(target=target, command=word), timeout=60)
    assert answer.results, answer.message
    return [one.device for one in answer.results]


async def test_the_name_of_a_group_of_a_gateway_means_its_members(home: Home) -> None:
    await put_lamps(home)
    assert await do(home, "group") == sorted(LAMPS)
    assert keys(home) == ["group"]


async def test_a_group_whose_members_are_unknown_is_told_itself(home: Home) -> None:
    _put(home, "lonely", ("on_off",), "id:away")
    await anyio.sleep(1)
    assert await do(home, "lonely") == ["lonely"]


async def test_everything_does_not_count_a_group_beside_its_members(home: Home) -> None:
    await put_lamps(home)
    assert await do(home, "everything") == sorted(LAMPS)


async def test_a_group_is_refused_what_one_of_its_members_is_refused(open_home: OpenHome) -> None:
    async with open_home(approvals=True) as home:
        _put(home, "lock", ("on_off",))
        door = simple_part("door_lock", settable=("lock",))
        home.gateway.devices.put(GatewayDevice("door", "Door", (door,), identifiers=("id:door",)), "it was found")
        group = simple_part("switch", settable=("on_off",)).model_copy(update={"members": ("id:lock", "id:door")})
        home.gateway.devices.put(GatewayDevice("all", "All", (group,), identifiers=("id:all",)), "it was found")
        await anyio.sleep(1)
        (outcome,) = await command(home, ON, "all")
        assert isinstance(outcome, Refused)
        assert outcome.reason.startswith("its member door is refused it: door needs a right that names it")
        assert home.commands == []


async def test_a_group_is_refused_while_a_lease_holds_one_of_its_members(home: Home) -> None:
    await put_lamps(home)
    await home.hold(hold_request("two", "on_off", False))
    home.commands.clear()
    (outcome,) = await command(home, ON, "group")
    assert isinstance(outcome, Refused)
    assert outcome.reason.startswith("its member two is refused it: ")
    assert keys(home) == []


@pytest.mark.parametrize(
    ("scope", "is_done"), [((), False), (("act: harmless",), False), (("act: id=group",), True), (("act: all",), True)]
)
async def test_a_client_that_may_not_command_a_plug_does_not_by_a_group_unless_its_right_names_that(
    home: Home, scope: tuple[str, ...], *, is_done: bool
) -> None:
    await put_lamps(home)
    freezer = GatewayDevice("two", "Freezer", (simple_part("plug", settable=("on_off",)),), identifiers=("id:two",))
    home.gateway.devices.put(freezer, "it is a plug")
    await home.report("two", "on_off", True)
    await anyio.sleep(1)
    (outcome,) = await command(home, {"on_off": False}, "group", issuer="client:tablet", scope=scope)
    assert outcome.succeeded is is_done
    assert keys(home) == ["group"] * is_done
