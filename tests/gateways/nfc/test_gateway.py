"""A tag that is held to a reader says which device is meant; nfcpy reads a simulated tag over UDP."""

import json

import pytest
from tests.gateways.nfc.world import UID, card, tag_house, take, uri
from tests.patience import PATIENCE
from tests.simulated.nfc.field import TagField
from tests.simulated.nfc.type4_card import Type4Card

from homebot.conventions.nfc.ndef_message import NdefRecord, read_ndef, write_ndef
from homebot.devices import FIND_DEVICES, Device, Endpoint, FindDevices, Sighting
from homebot.devices.device import KeyValue
from homebot.devices.gateway_messages import Report
from homebot.devices.services import FindDevicesRequest, FindDevicesResponse
from homebot.devices.tags import ReadTag, ReadTagRequest, ScanCode, ScanCodeRequest, TagTap, WriteTag, WriteTagRequest
from homebot.graph import Node
from homebot.messages.builtin_interfaces import Time

NOW = Time(sec=1, nanosec=0)


def device(id_: str, name: str, **more: object) -> Device:
    values: dict[str, object] = {
        "id": id_,
        "name": name,
        "service_type": "light",
        "endpoints": (Endpoint(gateway="mqtt", key=id_, address=f"home/{id_}/out", command_address=""),),
        "metadata": (),
        "first_seen": NOW,
        "last_seen": NOW,
        "expires": NOW,
        "freshness": "fresh",
        **more,
    }
    return Device.model_validate(values)


LAMP = device(
    "lights/kitchen",
    "Kitchen lamp",
    identifiers=("mac:aabbccddee01", "id:urn:dev:lamp:1"),
    metadata=(KeyValue(key="host", value="desk-strip.local"), KeyValue(key="ip_address", value="10.0.0.7")),
)
PLUG = device(
    "plugs/matter", "Plug", metadata=(KeyValue(key="txt_D", value="3840"), KeyValue(key="txt_VP", value="65521+32768"))
)
HOUSE = (LAMP, PLUG, device("lights/hall", "Lamp"), device("lights/cellar", "Lamp"))


def directory(node: Node) -> None:
    def answer(request: FindDevicesRequest) -> FindDevicesResponse:
        del request
        return FindDevicesResponse(devices=HOUSE, sequence=0)

    node.create_service(FindDevices, FIND_DEVICES, answer)


THING = {
    "@context": "https://www.w3.org/2022/wot/td/v1.1",
    "id": "urn:dev:fan:9",
    "title": "Fan",
    "securityDefinitions": {"nosec": {"scheme": "nosec"}},
    "security": ["nosec"],
}


async def test_a_tag_is_sighted_and_its_event_says_that_it_was_read() -> None:
    async with tag_house(tags={"04:A1:B2:C3:D4:E5:F6": {"name": "Door tag", "area": "Hall"}}) as house:
        sightings, reports = house.listen(Sighting, "received_topics"), house.listen(Report, "readings")
        house.field.card = card(uri("homebot:device/lights/kitchen"))
        sighting = await take(sightings)
        assert (sighting.key, sighting.name, sighting.area, sighting.service_type) == (UID, "Door tag", "Hall", "x_tag")
        readings = [one for _ in range(2) for one in (await take(reports)).readings]
        assert {one.capability: one.value.plain() for one in readings} == {"connectivity": True, "scan": UID}
        house.field.card = None
        (reading,) = (await take(reports)).readings
        assert (reading.capability, reading.value.plain()) == ("connectivity", False)


async def test_a_tap_says_which_device_is_meant_and_where() -> None:
    async with tag_house() as house:
        directory(house.watcher)
        taps = house.listen(TagTap, "taps")
        house.field.card = card(
            write_ndef(NdefRecord("uri", b"homebot:device/lights/kitchen"), NdefRecord("text", b"area: Attic"))
        )
        tap = await take(taps)
        assert (tap.tag, tap.device, tap.area, tap.reader) == (UID, LAMP.id, "Attic", house.field.path)


async def test_the_settings_count_more_than_the_tag() -> None:
    async with tag_house(tags={UID: {"device": "Kitchen lamp", "area": "Hall"}}) as house:
        directory(house.watcher)
        taps = house.listen(TagTap, "taps")
        house.field.card = card(uri("homebot:device/plugs/matter"))
        tap = await take(taps)
        assert (tap.device, tap.area) == (LAMP.id, "Hall")


@pytest.mark.rooms("things")
async def test_a_thing_that_only_a_tag_describes_becomes_a_device_without_commands() -> None:
    async with tag_house() as house:
        sightings = house.listen(Sighting, "received_topics")
        house.field.card = card(write_ndef(NdefRecord("media", json.dumps(THING).encode(), "application/td+json")))
        assert (await take(sightings)).key == UID
        thing = await take(sightings)
        assert (thing.name, thing.identifiers, thing.confirmed) == ("Fan", ("id:urn:dev:fan:9",), False)
        assert [one.capabilities for one in thing.parts] == [()]


async def test_a_tag_that_holds_no_message_of_the_protocol_is_counted_and_not_listed() -> None:
    async with tag_house() as house:
        taps = house.listen(TagTap, "taps")
        house.field.card = card(b"\xd1\xff\x00?")
        assert (await take(taps)).points_to == ""
        assert house.gateway.devices.counters.rejected == 1
        assert house.gateway.devices.keys == ()


async def test_a_number_that_is_drawn_anew_each_time_is_not_listed() -> None:
    async with tag_house() as house:
        taps = house.listen(TagTap, "taps")
        house.field.card = card(uri("http://desk-strip.local/"), uid="08112233")
        assert (await take(taps)).tag == "08112233"
        assert house.gateway.devices.keys == ()


@pytest.mark.newest("nfc")
async def test_a_tag_is_written_and_read_again() -> None:
    async with tag_house() as house:
        directory(house.watcher)
        house.field.card = card()
        write = house.watcher.create_client(WriteTag, "/gateway/nfc/write_tag")
        written = await write.call(WriteTagRequest(device="Kitchen lamp", area="Attic", wait=5))
        assert (written.success, written.message, written.device, written.tag) == (True, "", LAMP.id, UID)
        records = read_ndef(house.field.card.message)
        assert [(one.kind, one.data) for one in records] == [
            ("uri", b"homebot:device/lights/kitchen"),
            ("text", b"Kitchen lamp\narea: Attic"),
        ]
        read = house.watcher.create_client(ReadTag, "/gateway/nfc/read_tag")
        again = await read.call(ReadTagRequest(wait=5))
        assert (again.device, again.area, again.message) == (LAMP.id, "Attic", "it points to Kitchen lamp")


class LeavingCard(Type4Card):
    """A tag that is replaced by another while it is written."""

    def __init__(self, field: TagField, other: Type4Card) -> None:
        super().__init__(bytes.fromhex(UID))
        self._field = field
        self._other = other

    def answer(self, apdu: bytes) -> bytes:
        if apdu[1:2] == b"\xd6":
            self._field.card = self._other
        return super().answer(apdu)


async def test_a_tag_that_leaves_while_it_is_written_is_lost_and_the_next_one_is_read() -> None:
    async with tag_house() as house:
        directory(house.watcher)
        taps = house.listen(TagTap, "taps")
        house.field.card = LeavingCard(house.field, card(uri("homebot:device/lights/hall"), uid="04ffeeddccbbaa"))
        write = house.watcher.create_client(WriteTag, "/gateway/nfc/write_tag")
        written = await write.call(WriteTagRequest(device="Kitchen lamp", wait=PATIENCE), timeout=PATIENCE)
        assert (written.success, written.problem, written.tag) == (False, "lost", UID)
        assert "was taken away" in written.message
        while (tap := await take(taps)).tag == UID:
            pass
        assert (tap.tag, tap.device) == ("04ffeeddccbbaa", "lights/hall")
        assert tuple(house.gateway.at_reader) == ("04ffeeddccbbaa",)


class SilentCard(Type4Card):
    """A tag that announces a message, of which it gives nothing."""

    asked = 0

    def answer(self, apdu: bytes) -> bytes:
        is_message = self._selected == 0xE104 and apdu[:4] == b"\x00\xb0\x00\x02"
        self.asked += is_message
        return b"\x90\x00" if is_message else super().answer(apdu)


async def test_a_tag_that_gives_nothing_is_not_asked_for_ever() -> None:
    async with tag_house() as house:
        taps = house.listen(TagTap, "taps")
        house.field.card = silent = SilentCard(bytes.fromhex(UID), uri("homebot:device/lights/kitchen"))
        assert (await take(taps)).points_to == ""
        assert 1 < silent.asked <= 4096


@pytest.mark.parametrize(
    ("presented", "asked", "problem", "said"),
    [
        (card(capacity=20), {}, "too_small", "holds 20 bytes"),
        (card(is_writable=False), {}, "protected", "write-protected"),
        (None, {"wait": 0.3}, "no_tag", "within 0.3 s"),
        (None, {"reader": "desk"}, "no_reader", "no reader 'desk'"),
        (None, {"device": "Lamp"}, "no_device", "several devices: lights/hall, lights/cellar"),
        (None, {"device": "nobody"}, "no_device", "no known device"),
    ],
)
async def test_a_tag_that_cannot_be_written_says_why(
    presented: object, asked: dict[str, object], problem: str, said: str
) -> None:
    async with tag_house() as house:
        directory(house.watcher)
        house.field.card = presented  # type: ignore[assignment]
        write = house.watcher.create_client(WriteTag, "/gateway/nfc/write_tag")
        request = WriteTagRequest.model_validate({"device": "Kitchen lamp", "wait": 5, **asked})
        response = await write.call(request)
        assert (response.success, response.problem) == (False, problem)
        assert said in response.message


@pytest.mark.parametrize(
    ("text", "kind", "meant"),
    [
        ("homebot:device/lights/kitchen", "homebot", LAMP.id),
        ("Kitchen Lamp", "text", LAMP.id),
        ("AA:BB:CC:DD:EE:01", "text", LAMP.id),
        ("http://desk-strip.local/.well-known/wot", "url", LAMP.id),
        ("coap://10.0.0.7", "url", LAMP.id),
        ("mqtt://broker/home/lights/kitchen", "mqtt", LAMP.id),
        pytest.param(json.dumps(THING | {"id": "urn:dev:lamp:1"}), "thing", LAMP.id, marks=pytest.mark.rooms("things")),
        pytest.param("MT:Y.K90AFN00KA0648G00", "matter", PLUG.id, marks=pytest.mark.rooms("matter")),
        ("https://example.org/?u=1", "url", ""),
        ("Lamp", "text", ""),
    ],
)
async def test_a_code_says_which_device_it_is(text: str, kind: str, meant: str) -> None:
    async with tag_house() as house:
        directory(house.watcher)
        scan = house.watcher.create_client(ScanCode, "/gateway/nfc/scan")
        answer = await scan.call(ScanCodeRequest(text=text))
        assert (answer.success, answer.kind, answer.device) == (True, kind, meant), answer
        assert answer.candidates == (("lights/hall", "lights/cellar") if text == "Lamp" else (meant,) if meant else ())


async def test_an_ndef_message_of_another_reader_is_a_code_too() -> None:
    async with tag_house() as house:
        directory(house.watcher)
        scan = house.watcher.create_client(ScanCode, "/gateway/nfc/scan")
        assert (await scan.call(ScanCodeRequest(ndef=uri("homebot:device/lights/kitchen")))).device == LAMP.id
        wrong = await scan.call(ScanCodeRequest(ndef=b"\xd1\xff\x00?"))
        assert (wrong.success, "NDEF" in wrong.message) == (False, True)


@pytest.mark.rooms("matter")
async def test_a_setup_code_that_is_invalid_is_refused() -> None:
    async with tag_house() as house:
        scan = house.watcher.create_client(ScanCode, "/gateway/nfc/scan")
        empty = await scan.call(ScanCodeRequest(text="MT:?"))
        assert (empty.success, "base 38" in empty.message) == (False, True)
