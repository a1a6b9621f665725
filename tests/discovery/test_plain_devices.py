"""Devices that a topic alone tells of: one part by guess, words on an address of their own."""

from tests.announcements import sighting_of
from tests.discovery.announcements import part_of, tell

from homebot.devices import Sighting
from homebot.devices.part import Part
from homebot.discovery import DeviceIndex
from homebot.words.queries import parse_query

KEY, OUT, IN = "lights/lamp", "home/lights/lamp/out", "home/lights/lamp/in"


def lamp(part: Part | None) -> Sighting:
    return sighting_of(
        KEY,
        *(() if part is None else (part,)),
        kind="appeared",
        name="lamp",
        service_type="lights",
        address=OUT,
        command_address=IN,
        lasts=60,
    )


def light() -> Part:
    return part_of("light", "on_off", reads=(OUT,), writes=(IN,), advertised="lights", guessed=True)


def test_its_id_its_word_and_its_addresses_are_its_own() -> None:
    """As if it had no part."""
    index, partless = DeviceIndex(forget_after=1000), DeviceIndex(forget_after=1000)
    index.observe(lamp(light()))
    partless.observe(lamp(None))
    (device,), (other,) = index.devices(), partless.devices()
    assert (device.id, device.service_type, device.service_types) == (KEY, "lights", ("light", "lights"))
    assert [(one.address, one.command_address) for one in device.endpoints] == [(OUT, IN)]
    assert device.model_copy(update={"parts": ()}) == other
    assert [(one.gateway, one.key, one.part) for one in device.parts[0].routes] == [("mqtt", KEY, "")]


def test_it_is_found_by_word_by_type_and_by_what_it_says() -> None:
    index = DeviceIndex(forget_after=1000)
    sighting = lamp(light())
    index.observe(sighting)
    assert index.find(parse_query("on lights")) == set()
    index.report(tell(sighting, "on_off", value=True))
    for query in ("on lights", "lights", "lamp", "type=light", "can=on_off", "on_off=true"):
        assert index.find(parse_query(query)) == {KEY}, query
    assert [one.id for one in index.devices("lights")] == [KEY]


def test_a_lamp_of_an_older_homebot_gets_its_part_when_it_speaks() -> None:
    """The index file knew it without."""
    index = DeviceIndex(forget_after=1000)
    index.observe(lamp(None))
    index.pop_changes()
    index.observe(lamp(light()).model_copy(update={"kind": "updated"}))
    (change,) = index.pop_changes()
    assert (change.kind, change.device.id, len(change.device.parts)) == ("changed", KEY, 1)
