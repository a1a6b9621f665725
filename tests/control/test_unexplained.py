"""Changes that no command explains, and raw commands, in virtual time."""

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, obey_after, report
from tests.control.test_journal import kinds
from tests.control.test_motors import Step, on_the_way

from homebot.clock import LoopClock
from homebot.devices import Device, GatewayNames, RawCommand
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Handle, Light, WindowCovering
from homebot.devices.journal_messages import GetCauses, GetCausesRequest, JournalEntry
from homebot.devices.names import GET_CAUSES
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Node

pytestmark = pytest.mark.virtual_time


async def publish(home: Home, lamp: Device, text: str, issuer: str = "/app") -> None:
    """Publish a raw command for the gateway, as a program that knows topics alone does."""
    out = home.app.create_publisher(RawCommand, GatewayNames("memory").out)
    out.publish(RawCommand(address=lamp.endpoints[0].command_address, payload=text, issuer=issuer))
    await anyio.sleep(0.01)


async def changes(home: Home) -> list[JournalEntry]:
    await anyio.sleep(1)
    return [one for one in (await home.read()).entries if one.kind == "changed"]


async def test_a_hand_at_the_switch_is_in_the_journal(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    await anyio.sleep(1)
    await home.report("lamp", "on_off", False)
    assert await changes(home) == []  # how it is, and no change
    await home.report("lamp", "on_off", True)
    (change,) = await changes(home)
    assert [(one.capability, one.value.plain()) for one in change.settings] == [("on_off", True)]
    assert (change.command, change.issuer, change.trigger.kind) == ("", "", "")


@pytest.mark.parametrize("is_commanded", [False, True])
async def test_a_change_after_an_absence_may_be_the_device_s_own(home: Home, *, is_commanded: bool) -> None:
    """An accessory that restarts begins with the values that it has then."""
    home.put("lamp", "light", "on_off")
    await home.report("lamp", "on_off", True)
    await anyio.sleep(1)
    if is_commanded:
        home.behaviours["lamp"] = obey_after(0.1)
        assert (await (await home.handle(Light)).turn_off()).succeeded
        assert (await (await home.handle(Light)).turn_on()).succeeded
    await anyio.sleep(120)
    home.gateway.devices.report_reachable("lamp", reachable=True)
    home.gateway.devices.report_reachable("lamp", reachable=False)
    await anyio.sleep(1)
    await home.report("lamp", "on_off", False)
    home.gateway.devices.report_reachable("lamp", reachable=True)
    await anyio.sleep(30)
    home.gateway.set_unavailable("the cable is out")
    await anyio.sleep(1)
    home.gateway.set_available()
    await home.report("lamp", "on_off", True)
    await anyio.sleep(30)
    await home.report("lamp", "on_off", False)
    assert [one.cause for one in await changes(home)] == ["unknown", "unknown", "person"]


async def test_the_absence_of_another_part_explains_nothing(home: Home) -> None:
    relay = simple_part("switch", settable=("on_off",))
    relays = tuple(relay.model_copy(update={"id": one}) for one in ("left", "right"))
    home.gateway.devices.put(GatewayDevice("strip", "Strip", relays), "the test says so")
    for value in (False, True):
        for one in relays:
            await home.gateway.devices.report("strip", {"on_off": value}, one.id)
        await anyio.sleep(1)
        home.gateway.devices.report_reachable("strip", "left", reachable=value)
        await anyio.sleep(1)
    assert {one.part: one.cause for one in await changes(home)} == {"left": "unknown", "right": "person"}


async def test_a_value_that_is_unknown_for_a_while_is_no_change(home: Home) -> None:
    """Home Assistant knows no states of MQTT when it has just started."""
    home.put("lamp", "light", "on_off")
    for value in (False, None, False, None, True):
        await anyio.sleep(1)
        await home.report("lamp", "on_off", value)
    (change,) = await changes(home)
    assert [one.value.plain() for one in change.settings] == [True]


async def test_what_a_command_does_is_explained_and_what_comes_later_is_not(home: Home) -> None:
    home.put("lamp", "light", "on_off", "level")
    await home.report("lamp", "on_off", False)
    await home.report("lamp", "level", 0.0)
    home.behaviours["lamp"] = report((0.1, 40.0))
    home.later(1.2, "lamp", "on_off", True)  # what comes along with the level
    await anyio.sleep(1)
    assert (await (await home.handle(Light)).set_level(40)).succeeded
    await anyio.sleep(5)
    assert await changes(home) == []
    await anyio.sleep(30)
    await home.report("lamp", "on_off", False)
    assert len(await changes(home)) == 1


@pytest.mark.parametrize(
    "arrival",
    [
        pytest.param([(10.0, {"movement": "open", "position": 50.0})], id="Home Assistant: open, and its position"),
        pytest.param([(10.0, {"movement": "stopped"}), (10.4, {"position": 50.0})], id="Shelly: stopped, then where"),
        pytest.param([(10.0, {"position": 50.0}), (10.4, {"movement": "stopped"})], id="Tasmota: where, then stopped"),
    ],
)
async def test_a_cover_that_rests_where_it_was_sent_is_explained(home: Home, arrival: list[Step]) -> None:
    home.put("cover", "window_covering", "movement", "position")
    await home.gateway.devices.report("cover", {"movement": "closed", "position": 0.0})
    await anyio.sleep(1)
    home.behaviours["cover"] = on_the_way((0.5, {"movement": "opening"}), *arrival)
    assert (await (await home.handle(WindowCovering)).set_position(50)).succeeded
    assert await changes(home) == []
    await anyio.sleep(10)
    await home.report("cover", "movement", "closed")
    assert [one.settings[0].value.plain() for one in await changes(home)] == ["closed"]


async def test_a_cover_that_stops_elsewhere_was_stopped(home: Home) -> None:
    home.put("cover", "window_covering", "movement", "position")
    await home.gateway.devices.report("cover", {"movement": "closed", "position": 0.0})
    await anyio.sleep(1)
    stop: Step = (5.0, {"movement": "stopped", "position": 20.0})
    home.behaviours["cover"] = on_the_way((0.5, {"movement": "opening"}), stop)
    assert not (await (await home.handle(WindowCovering)).set_position(50)).succeeded
    assert [one.settings[0].value.plain() for one in await changes(home)] == ["stopped"]


async def test_a_volume_that_is_only_reported_comes_along_with_on(home: Home) -> None:
    """A television that is off has none."""
    home.put("tv", "video_player", "on_off", readable=("volume",))
    await home.gateway.devices.report("tv", {"on_off": False, "volume": None})
    await anyio.sleep(1)

    async def turn_on(home: Home, command: Command) -> None:
        await home.gateway.devices.report("tv", {"on_off": True, "volume": 30.0})

    home.behaviours["tv"] = turn_on
    assert (await (await home.handle(Handle)).command("on_off", True)).succeeded
    assert await changes(home) == []
    await anyio.sleep(20)
    await home.report("tv", "volume", 40.0)
    assert len(await changes(home)) == 1


async def test_a_sensor_needs_no_reason(home: Home) -> None:
    home.put("meter", "temperature_sensor", readable=("temperature",))
    await home.report("meter", "temperature", 20.0)
    await home.report("meter", "temperature", 21.0)
    assert await changes(home) == []


async def test_a_dial_that_is_turned_is_one_change(home: Home) -> None:
    home.put("lamp", "light", "level")
    await home.report("lamp", "level", 10.0)
    await anyio.sleep(20)
    for level in range(20, 60):
        await home.report("lamp", "level", float(level))
        await anyio.sleep(0.2)
    assert len(await changes(home)) == 1


async def test_the_effect_of_a_slow_command_is_explained_as_long_as_it_takes(home: Home) -> None:
    await (await home.lamp("on_off", before={"on_off": False}, behaviour=obey_after(9.0))).turn_on()
    assert await changes(home) == []


async def test_a_raw_command_explains_what_the_device_reports(home: Home) -> None:
    lamp = (await home.lamp("on_off", before={"on_off": False})).device
    home.later(0.3, "lamp", "on_off", True)
    await publish(home, lamp, "on")
    assert await changes(home) == []
    found = await home.read()
    assert kinds(found) == ["published", "reported"]
    published, reported = found.entries
    assert (published.issuer, published.text, published.device) == ("/app", "on", lamp.id)
    assert published.command == reported.command != ""


async def test_a_raw_command_that_is_known_after_its_effect_explains_it_all_the_same(home: Home) -> None:
    lamp = (await home.lamp("on_off", before={"on_off": False})).device
    await anyio.sleep(1)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(1)
    await home.report("lamp", "on_off", False)
    await anyio.sleep(0.1)
    await publish(home, lamp, "off")
    assert [one.settings[0].value.plain() for one in await changes(home)] == [True]


@pytest.mark.parametrize(("text", "explained"), [('{"state": "ON"}', ["left", "right"]), ("on", ["left"])])
async def test_a_raw_command_explains_its_part_or_the_whole_device_if_it_is_not_understood(
    home: Home, text: str, explained: list[str]
) -> None:
    relay = simple_part("switch", settable=("on_off",))
    relays = tuple(relay.model_copy(update={"id": one, "writes": (f"strip/{one}",)}) for one in ("left", "right"))
    home.gateway.devices.put(GatewayDevice("strip", "Strip", relays), "the test says so")
    for one in relays:
        await home.gateway.devices.report("strip", {"on_off": False}, one.id)
    await anyio.sleep(1)
    out = home.app.create_publisher(RawCommand, GatewayNames("memory").out)
    out.publish(RawCommand(address="strip/left", payload=text))
    for one in relays:
        await anyio.sleep(4)
        await home.gateway.devices.report("strip", {"on_off": True}, one.id)
    await anyio.sleep(1)
    found = (await home.read()).entries
    assert sorted(one.part for one in found if one.kind == "reported") == explained
    assert [one.cause for one in found if one.kind == "changed"] == ["person"] * (2 - len(explained))


async def test_a_raw_command_explains_what_undoes_another_command(home: Home) -> None:
    lamp = await home.lamp("on_off", before={"on_off": False})
    await anyio.sleep(1)
    await lamp.turn_on()
    await anyio.sleep(1)
    await publish(home, lamp.device, "off")
    await home.report("lamp", "on_off", False)
    assert await changes(home) == []
    found = await home.read()
    assert kinds(found)[-3:] == ["outcome", "published", "reported"]
    assert found.entries[-1].command == found.entries[-2].command


async def test_what_is_reported_in_the_moment_of_the_command_is_explained(open_home: OpenHome) -> None:
    """At a time whose nanoseconds since 1970 are rounded down where they are counted as one float."""
    async with open_home(clock=LoopClock(1795362342.6555853)) as home:
        lamp = await home.lamp("on_off", before={"on_off": False})
        await anyio.sleep(1)
        await lamp.turn_on()
        assert await changes(home) == []


async def test_a_raw_command_with_an_id_of_its_own_is_recorded_with_a_new_one(home: Home) -> None:
    """A program could hide what it did, or lay it at the door of another command."""
    home.put("lamp", "light", "on_off")
    lamp = await home.handle(Light)
    out = home.app.create_publisher(RawCommand, GatewayNames("memory").out)
    address = lamp.device.endpoints[0].command_address
    out.publish(RawCommand(address=address, payload="on", issuer="client:guest", command_id="c-1"))
    await anyio.sleep(1)
    (published,) = [one for one in (await home.read()).entries if one.kind == "published"]
    assert (published.issuer, published.text) == ("client:guest", "on")
    assert published.command not in {"", "c-1"}


async def test_a_raw_command_of_nobody_known_is_there_too(home: Home) -> None:
    lamp = (await home.lamp("on_off")).device
    await publish(home, lamp, "on", issuer="")
    await anyio.sleep(1)
    (published,) = (await home.read()).entries
    assert (published.kind, published.issuer, published.device) == ("published", "", lamp.id)


async def test_a_hand_is_known_also_by_another_gateway_than_that_of_the_last_command(open_home: OpenHome) -> None:
    """A hub comes that has the lamp, too, and the bridge by which it was commanded loses it."""
    async with open_home() as home:
        part = simple_part("light", settable=("on_off",))
        lamp = GatewayDevice("lamp", "Lamp", (part,), identifiers=("mac:aabbccddeeff",))
        home.gateway.devices.put(lamp, "the test says so")
        await home.report("lamp", "on_off", False)
        await (await home.handle(Light)).turn_on()
        hub = MemoryGateway(Node(home.graph, "hub", namespace="/gateway"))
        await home.tasks.start(hub.serve)
        hub.devices.put(lamp, "the test says so")
        await hub.devices.report("lamp", {"on_off": True})
        home.gateway.devices.remove("lamp", "the test says so")
        await anyio.sleep(1000)
        await hub.devices.report("lamp", {"on_off": False})
        (change,) = await changes(home)
        causes = home.app.create_client(GetCauses, GET_CAUSES)
        (known,) = (await causes.call(GetCausesRequest(devices=("lamp",)))).causes
        assert (known.value.plain(), known.cause) == (False, change.cause)
        assert known.may_be_person
