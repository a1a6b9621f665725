"""Commands of programs outside: what the rights of each allow, whoever it says it is; in virtual time."""

import pytest
from tests.control.conftest import Home, OpenHome, hold_request, refusal

from homebot.devices.command_messages import (
    CommandDevices,
    CommandDevicesRequest,
    CommandRequest,
    CommandResult,
    Setting,
)
from homebot.devices.handles import DoorLock, Handle, Light
from homebot.devices.names import COMMAND_DEVICES
from homebot.devices.outcomes import Confirmed
from homebot.devices.value import Value

pytestmark = pytest.mark.virtual_time


async def put_house(home: Home) -> None:
    home.put("relay", "switch", "on_off", area="hall", name="Coffee")
    home.put("lamp", "light", "on_off", area="hall")
    home.put("other", "light", "on_off", area="attic")
    home.put("door", "door_lock", "lock", area="hall")
    await home.handle(Light, "lamp")


async def unlock(home: Home, issuer: str, *scope: str, value: str = "unlocked") -> CommandResult:
    lock = await home.handle(DoorLock, "door")
    setting = Setting(capability="lock", value=Value.of(value))
    request = CommandRequest(device=lock.device.id, part="", settings=(setting,), issuer=issuer, scope=scope)
    return CommandResult.of(await home.control.perform(request))


@pytest.mark.parametrize("scope", [(), ("act: light",), ("act: in hall",), ("act: lock in attic",)])
async def test_a_client_without_the_right_does_not_unlock(home: Home, scope: tuple[str, ...]) -> None:
    """It is refused by a policy, with the reason, and the lock hears nothing."""
    await put_house(home)
    result = await unlock(home, "client:robot", *scope)
    assert (result.outcome, result.policy, home.commands) == ("refused", "rights", [])
    assert result.reason.startswith("client:robot may not command ")
    assert "such a device needs a right that names it" in result.reason


@pytest.mark.parametrize(
    ("issuer", "scope", "advice"),
    [
        ("client:local", (), "make a token: homebot token new NAME --scope read --scope {}"),
        ("client:local", ("read", "act: light"), "add {} to that, in the table [door] of homebot.toml"),
        ("client:robot", ("act: light",), "add {} to that, in the table [door.tokens.robot] of homebot.toml"),
    ],
)
async def test_the_refusal_says_where_the_right_is_given(
    home: Home, issuer: str, scope: tuple[str, ...], advice: str
) -> None:
    await put_house(home)
    result = await unlock(home, issuer, *scope)
    lock = await home.handle(DoorLock, "door")
    assert result.reason.endswith(advice.format(f"""'act: id="{lock.device.id}"'"""))


@pytest.mark.parametrize("approvals", [True, False])
async def test_one_refusal_names_right_and_approval(open_home: OpenHome, *, approvals: bool) -> None:
    """To a client as to an app, with the reason why the device always asks; no approval if none is needed."""
    async with open_home(approvals=approvals) as home:
        await put_house(home)
        of_app = await refusal((await home.handle(DoorLock, "door")).unlock())
        for reason in ((await unlock(home, "client:robot")).reason, of_app):
            assert "a right that names it (it is a door lock)" in reason
            assert ("; approve it with `homebot approve Door`, and " in reason) is approvals
            assert (
                "homebot token new NAME" in reason
                or "only an app or a routine can have one, by its key `act`" in reason
            )


@pytest.mark.parametrize("scope", [(), ("read", "act: harmless")])
async def test_who_may_command_what_is_harmless_locks(home: Home, scope: tuple[str, ...]) -> None:
    """As an app without a grant may."""
    await put_house(home)
    assert (await unlock(home, "client:local", *scope, value="locked")).outcome == "confirmed"


async def switch(home: Home, issuer: str, *scope: str) -> CommandResult:
    device = (await home.handle(Handle, "Coffee")).device
    setting = Setting(capability="on_off", value=Value.of(False))
    request = CommandRequest(device=device.id, part="", settings=(setting,), issuer=issuer, scope=scope)
    return CommandResult.of(await home.control.perform(request))


@pytest.mark.parametrize(
    ("scope", "advice"),
    [
        ((), "make a token: homebot token new NAME --scope read --scope 'act: id=\"{}\"'"),
        (("read", "act: harmless"), "add 'act: id=\"{}\"' to that, in the table [door] of homebot.toml"),
    ],
)
async def test_a_local_program_commands_no_relay_that_the_owner_did_not_call_harmless(
    home: Home, scope: tuple[str, ...], advice: str
) -> None:
    """Nor turns it off: the refusal has the reason and the line that changes it."""
    await put_house(home)
    result = await switch(home, "client:local", *scope)
    assert (result.outcome, result.policy, home.commands) == ("refused", "rights", [])
    assert "not on the list of harmless devices (nothing but its name says what this switch turns on)" in result.reason
    device = (await home.handle(Handle, "Coffee")).device
    advised = f"if it can hurt nobody, `homebot tag add Coffee harmless`, otherwise {advice.format(device.id)}"
    assert result.reason.endswith(advised)


@pytest.mark.parametrize("scope", ["act: ordinary", "act: switch", "act: in hall", "act: all"])
async def test_a_token_with_a_wider_right_commands_it(home: Home, scope: str) -> None:
    await put_house(home)
    assert (await switch(home, "client:agent", "act: harmless", scope)).outcome == "confirmed"


@pytest.mark.parametrize("scope", [("act: light",), ("act: in hall",)])
async def test_who_may_command_some_devices_alone_locks_no_other(home: Home, scope: tuple[str, ...]) -> None:
    await put_house(home)
    result = await unlock(home, "client:robot", *scope, value="locked")
    assert (result.outcome, result.policy, home.commands) == ("refused", "rights", [])


async def test_to_hold_a_lock_locked_takes_a_right_that_names_it(home: Home) -> None:
    """A lease keeps others from unlocking, those who have the right as well."""
    await put_house(home)
    lock = await home.handle(DoorLock, "door")
    answer = await home.hold(hold_request(lock.device.id, "lock", "locked", "client:local"))
    assert (answer.held, answer.result.policy, home.commands) == (False, "rights", [])
    answer = await home.hold(hold_request(lock.device.id, "lock", "locked", "/app"))
    assert (answer.held, answer.result.policy, home.commands) == (False, "always_ask", [])


@pytest.mark.parametrize("scope", ["act: all", "act: lock", "act: lock in hall", 'act: name="Door"'])
async def test_a_client_with_the_right_unlocks(home: Home, scope: str) -> None:
    await put_house(home)
    assert (await unlock(home, "client:robot", scope)).outcome == "confirmed"


async def test_an_unreadable_scope_allows_nothing(home: Home) -> None:
    await put_house(home)
    result = await unlock(home, "client:robot", "unlock everything")
    assert (result.outcome, result.policy) == ("refused", "rights")


async def test_a_query_commands_what_the_client_may_and_says_what_not(home: Home) -> None:
    await put_house(home)
    request = CommandDevicesRequest(target="lights", command="on", issuer="client:robot", scope=("act: in hall",))
    answer = await home.app.create_client(CommandDevices, COMMAND_DEVICES).call(request)
    assert (answer.success, answer.outcome) == (False, "refused")
    assert sorted((one.name, one.result.outcome) for one in answer.results) == [
        ("Lamp", "confirmed"),
        ("Other", "refused"),
    ]
    refused = next(one.result for one in answer.results if one.result.outcome == "refused")
    assert "it is not among what the client may command" in refused.reason
    assert [one.key for one in home.commands] == ["lamp"]


async def test_an_app_is_no_client_and_has_the_rights_of_its_table(open_home: OpenHome) -> None:
    async with open_home(grants={"/app": ("act: lock",)}) as home:
        await put_house(home)
        lock = await home.handle(DoorLock, "door")
        assert isinstance(await lock.unlock(), Confirmed)
