"""The journal has that a code was given, and not which; in virtual time."""

import anyio
import pytest
from structlog.testing import capture_logs
from tests.control.conftest import Home, OpenHome, hold_request, ignore

from homebot.control.journal.given_codes import CODE_GIVEN, public_text
from homebot.devices import GatewayNames, RawCommand
from homebot.devices.command_messages import CommandRequest, Setting
from homebot.devices.handles import Handle
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import JOURNAL_ENTRIES
from homebot.devices.value import PlainValue, Value
from homebot.errors import LinkError
from homebot.recording.lines import CommandNews, RecordedCommand

pytestmark = pytest.mark.virtual_time

CODE = "73550173"


async def give(home: Home, key: str, capability: str, value: PlainValue) -> None:
    device = (await home.handle(Handle, key)).device
    setting = Setting(capability=capability, value=Value.of(value))
    scope = ("act: ordinary",)
    await home.control.perform(
        CommandRequest(device=device.id, part="", settings=(setting,), issuer="client:kitchen", scope=scope)
    )


@pytest.mark.parametrize(("capability", "code"), [("text", CODE), ("number", float(CODE))])
async def test_a_code_that_is_commanded_is_sent_and_kept_nowhere(
    open_home: OpenHome, capability: str, code: PlainValue
) -> None:
    """Nor published, logged or recorded; that one was given is."""
    with capture_logs() as lines:
        async with open_home() as home:
            seen: list[JournalEntry] = []
            home.app.create_subscription(JournalEntry, JOURNAL_ENTRIES, seen.append, 100)
            home.behaviours["keypad"] = ignore
            home.put("keypad", "x_setting", capability, name="Pin Code", is_silent=True)
            await give(home, "pin code", capability, code)
            assert [one.value.plain() for one in home.commands] == [code]
            found = (await home.read()).entries
            assert [one.kind for one in found] == ["requested", "sent", "acknowledged", "outcome"]
            assert [one.value.plain() for one in found[0].settings] == [CODE_GIVEN]
            recorded = CommandNews().of(found[0])
            assert isinstance(recorded, RecordedCommand)
            assert [one.value.plain() for one in recorded.settings] == [CODE_GIVEN]
    assert CODE not in f"{found} {seen} {lines}"


async def test_what_is_no_code_is_in_the_journal(home: Home) -> None:
    home.put("display", "x_setting", "text", is_silent=True)
    await give(home, "display", "text", "Dinner is ready")
    assert [one.value.plain() for one in (await home.read()).entries[0].settings] == ["Dinner is ready"]


async def test_a_code_is_not_held(home: Home) -> None:
    """Everybody may see what is held."""
    home.put("keypad", "x_setting", "text", name="Pin Code", is_silent=True)
    device = (await home.handle(Handle, "pin code")).device
    answer = await home.hold(hold_request(device.id, "text", CODE, "client:kitchen"))
    assert (answer.held, answer.result.reason) == (False, "a code is given once and cannot be held")
    (denied,) = (await home.read()).entries
    assert (denied.kind, CODE in str(denied)) == ("denied", False)
    assert home.commands == []


@pytest.mark.parametrize("text", [CODE, f"text={CODE}", f"user {CODE}"])
@pytest.mark.parametrize("capability", ["text", "number"])
async def test_a_text_for_what_takes_a_code_is_noted_without_it(home: Home, capability: str, text: str) -> None:
    """Whether or not it can be read, and whatever its address."""
    home.put("keypad", "x_setting", capability, name="Pin Code", is_silent=True)
    device = (await home.handle(Handle, "pin code")).device
    await home.devices.tell(device, text)
    found = (await home.read()).entries
    assert [one.kind for one in found] == ["requested", "published"]
    assert ([one.value.plain() for one in found[0].settings], found[1].text) == ([CODE_GIVEN], CODE_GIVEN)


@pytest.mark.parametrize(("name", "text"), [("Pin Code", CODE), ("Alarm", f'{{"code": "{CODE}"}}')])
async def test_a_code_that_is_not_sent_is_noted_nowhere(home: Home, name: str, text: str) -> None:
    home.put("keypad", "x_setting", "text", name=name, is_silent=True)
    device = (await home.handle(Handle, name.lower())).device
    home.gateway.set_unavailable("no link")
    with pytest.raises(LinkError, match=CODE):
        await home.devices.tell(device, text)
    found = (await home.read()).entries
    assert [one.kind for one in found] == ["requested", "outcome"]
    assert (CODE in str(found), "its gateway memory is unavailable: no link" in str(found[1])) == (False, True)


async def test_a_raw_text_with_a_code_is_noted_without_it(home: Home) -> None:
    address = (await home.new(Handle, "lamp", "on_off", service_type="light")).device.endpoints[0].command_address
    publisher = home.app.create_publisher(RawCommand, GatewayNames("memory").out)
    publisher.publish(RawCommand(address=address, payload=f'{{"action": "DISARM", "code": "{CODE}"}}'))
    await anyio.sleep(0.1)
    (noted,) = (await home.read()).entries
    assert (noted.kind, noted.text) == ("published", '{"action": "DISARM", "code": "***"}')


@pytest.mark.parametrize(
    ("address", "text", "noted"),
    [
        ("alarm/set", f'{{"action": "DISARM", "code": "{CODE}"}}', '{"action": "DISARM", "code": "***"}'),
        ("alarm/set", f'{{"code": {CODE}, "action": "DISARM"}}', '{"code": "***", "action": "DISARM"}'),
        (
            "lock/set",
            f'{{"pin_code": {{"user": 1, "pin_code": "{CODE}"}}}}',
            '{"pin_code": {"user": 1, "pin_code": "***"}}',
        ),
        ("lock/set", f'{{"wifi_password": "a \\" {CODE}"}}', '{"wifi_password": "***"}'),
        ("lock/set", f"user code {CODE}", CODE_GIVEN),
        ("zigbee2mqtt/lock/set/pin_code", CODE, CODE_GIVEN),
        ("lamp/set", '{"state": "ON", "color_mode": "xy"}', '{"state": "ON", "color_mode": "xy"}'),
        ("lamp/set", "on", "on"),
    ],
)
def test_of_a_raw_text_all_but_the_code_is_noted(address: str, text: str, noted: str) -> None:
    assert public_text(text, address) == noted


@pytest.mark.parametrize("text", ['{"' + "_" * 200_000, '{"a_' + "c" * 200_000 + '": "', '"a":"' * 50_000])
def test_a_long_text_is_read_in_part(text: str) -> None:
    """To look through all of it for the names of codes would hold everybody up."""
    assert len(public_text(text, "lamp/set")) == 5_000
