import random
from collections.abc import Mapping
from itertools import permutations

import pytest
from tests.integrations.announced_parts import Say, device_in, heard, part_in

from homebot.conventions.description import AnnouncementEvent, DeviceWithdrawn, Publication
from homebot.devices.part import CommandDescription
from homebot.errors import WireError
from homebot.integrations.homie.formats import Homie
from homebot.mqtt.topics import topic_matches

BASE = "homie/hall-lamp"
LAMP = {
    "$homie": "4.0.0",
    "$name": "Hall lamp",
    "$mac": "AA:BB:CC:00:11:22",
    "$fw/version": "0.4.0",
    "$nodes": "light",
    "light/$name": "Light",
    "light/$type": "light",
    "light/$properties": "on,color",
    "light/on/$datatype": "boolean",
    "light/on/$settable": "true",
    "light/color/$format": "rgb",
    "light/color/$settable": "true",
    "light/color/$datatype": "color",
    "$state": "ready",
}


def tell(say: Say, attributes: Mapping[str, str], base: str = BASE) -> tuple[AnnouncementEvent, ...]:
    """Say all attributes, and return all that was heard."""
    return tuple(heard for attribute, value in attributes.items() for heard in say(f"{base}/{attribute}", value))


def test_attributes_make_a_device(say: Say) -> None:
    device = device_in(tell(say, LAMP))
    assert device.key == BASE
    assert device.name == "Hall lamp"
    part, _alert = device.parts
    assert part.part.service_type == "light"
    assert {one.name for one in part.part.capabilities} == {"on_off", "color", "level"}
    assert part.codec.write("on_off", True) == (Publication(f"{BASE}/light/on/set", b"true", 2),)
    assert part.codec.write("color", (120.0, 100.0)) == (
        Publication(f"{BASE}/light/color/set", b"0,255,0", 2),
        Publication(f"{BASE}/light/on/set", b"true", 2),
    )
    assert part.codec.read(f"{BASE}/light/on", b"true", retained=True) == {"on_off": True}


def test_doctor_hears_of_one_that_died_while_it_announced_itself(homie: Homie, say: Say) -> None:
    """Its last will follows the attributes that it had published."""
    tell(say, {**dict(list(LAMP.items())[:9]), "$state": "init"})
    assert homie.problems() == ()
    say(f"{BASE}/$state", "lost")
    (problem,) = homie.problems()
    assert problem.startswith(f"{BASE} is announced in part")
    tell(say, LAMP)
    assert homie.problems() == ()


def test_doctor_hears_of_a_living_one_that_lists_what_it_does_not_announce(homie: Homie, say: Say) -> None:
    tell(say, {**LAMP, "$nodes": "light,fan"})
    assert len(homie.problems()) == 1
    say(f"{BASE}/$nodes", "light")
    assert homie.problems() == ()


def test_the_address_of_the_host_is_a_fact_and_no_identifier(say: Say) -> None:
    device = device_in(tell(say, LAMP))
    assert device.identifiers == ("id:homie/hall-lamp",)
    assert device.facts["host_mac"] == "AA:BB:CC:00:11:22"
    assert device.facts["sw_version"] == "0.4.0"


def test_any_order_that_ends_with_the_state_makes_it_once(say: Say) -> None:
    first = [name for name in LAMP if name != "$state"]
    for number, start in enumerate(permutations(first[:3])):
        base = f"homie/lamp{number}"
        order = [*reversed(first[3:]), *start, "$state"]
        assert len(tell(say, {name: LAMP[name] for name in order}, base)) == 1


LOCK = {
    "$homie": "3.0.1",
    "$name": "Front door",
    "$state": "ready",
    "$nodes": "bolt",
    "bolt/$name": "Bolt",
    "bolt/$type": "lock",
    "bolt/$properties": "state",
    "bolt/state/$datatype": "enum",
    "bolt/state/$format": "lock,unlock",
    "bolt/state/$settable": "true",
}


def test_an_approval_of_a_lock_outlasts_any_order_of_its_attributes(say: Say) -> None:
    """It may begin as another type, which no approval is for, and ends as the lock that was approved."""
    approved = described_at_last(say, LOCK)
    for number in range(100):
        order = random.Random(number).sample(list(LOCK), len(LOCK))  # noqa: S311 - not for secrets
        say(f"{BASE}/$state", "")
        assert described_at_last(say, {name: LOCK[name] for name in order}) == approved


def described_at_last(say: Say, attributes: Mapping[str, str]) -> CommandDescription:
    """Say all attributes, and return what an approval of the only part is bound to after the last of them."""
    *_, device = tell(say, attributes)
    device = device_in([device])
    part, _alert = device.parts
    return CommandDescription.of(part.part, device.identifiers)


def test_a_device_with_an_early_state_is_described_once_complete(say: Say) -> None:
    late = {"$state": "ready", **{name: value for name, value in LAMP.items() if name != "$state"}}
    assert device_in(tell(say, late)).name == "Hall lamp"


def test_a_ready_device_is_found_when_the_format_of_its_only_property_comes_last(say: Say) -> None:
    """Source: mjcumming/Homie4: a device says that it is ready, then its nodes, and of a speed the format last."""
    late = {
        "$homie": "4.0.0",
        "$name": "Attic fan",
        "$state": "ready",
        "$nodes": "speed",
        "speed/$type": "speed",
        "speed/$properties": "speed",
        "speed/speed/$settable": "true",
        "speed/speed/$datatype": "enum",
        "speed/speed/$format": "OFF,LOW,HIGH",
    }
    part, _alert = device_in(tell(say, late)).parts
    (capability,) = part.part.capabilities
    assert capability.options == ("OFF", "LOW", "HIGH")


@pytest.mark.parametrize(("settable", "is_settable"), [("True", True), ("true", True), ("False", False), ("", False)])
def test_settable_may_be_spelt_as_python_spells_it(say: Say, settable: str, *, is_settable: bool) -> None:
    """Source: mjcumming/Homie4 publishes the booleans of Python, which its MQTT client spells True and False."""
    part = device_in(tell(say, {**LAMP, "$nodes": "light", "light/on/$settable": settable})).parts[0]
    assert {one.name: one.settable for one in part.part.capabilities}.get("on_off", False) is is_settable


def test_retained_may_be_spelt_as_python_spells_it(say: Say) -> None:
    button = {
        "light/$properties": "press",
        "light/press/$datatype": "enum",
        "light/press/$format": "single,double",
        "light/press/$retained": "False",
    }
    kept = {name: value for name, value in LAMP.items() if not name.startswith(("light/on", "light/color", "$state"))}
    part, _alert = device_in(tell(say, {**kept, **button, "$state": "ready"})).parts
    assert [one.name for one in part.part.capabilities] == ["press"]


@pytest.mark.parametrize("missing", ["$nodes", "light/$properties", "light/on/$datatype", "$homie", "$state"])
def test_an_incomplete_one_is_no_device(say: Say, missing: str) -> None:
    assert tell(say, {name: value for name, value in LAMP.items() if name != missing}) == ()
    assert len(say(f"{BASE}/{missing}", LAMP[missing])) == 1


def test_a_property_of_version_3_without_datatype_is_a_text(say: Say) -> None:
    """Source: homie-esp8266 3.0, example SonoffDualShutters, and homie-device 3.0 (npm): datatypes are optional."""
    rest = {name: value for name, value in LAMP.items() if name not in {"light/on/$datatype", "$state"}}
    found = part_in(tell(say, {**rest, "$homie": "3.0.1", "$state": "ready"}), "light/on")
    assert heard(found, f"{BASE}/light/on", "true") == {"text": "true"}


def test_one_in_alert_has_a_problem_until_it_is_ready(say: Say) -> None:
    *_, alert = device_in(tell(say, LAMP)).parts
    for state, problem in (("alert", True), ("ready", False)):
        assert alert.codec.read(f"{BASE}/$state", state.encode(), retained=True) == {"problem": problem}
    assert alert.codec.read(f"{BASE}/$state", b"lost", retained=False) == {}


def test_a_starting_one_is_awaited(say: Say) -> None:
    assert tell(say, {**LAMP, "$state": "init"}) == ()
    assert len(say(f"{BASE}/$state", "alert")) == 1


def test_a_changed_attribute_describes_it_anew(say: Say) -> None:
    tell(say, LAMP)
    assert tell(say, LAMP) == ()
    assert device_in(say(f"{BASE}/$name", "Kitchen lamp")).name == "Kitchen lamp"


def test_other_attributes_change_nothing(say: Say) -> None:
    tell(say, LAMP)
    for attribute in ("$stats/uptime", "light/on", "light/on/set", "light/$x", "$extensions", "a/b/c/$name"):
        assert say(f"{BASE}/{attribute}", "60") == ()
    assert say(f"{BASE}/$state", "ready") == ()


def test_an_empty_state_removes_it(say: Say) -> None:
    tell(say, LAMP)
    assert say(f"{BASE}/$state", "") == (DeviceWithdrawn(BASE, "its state was removed", is_final=True),)
    assert tell(say, LAMP) != ()


def test_an_array_of_version_3_is_as_many_nodes(say: Say) -> None:
    relays = {
        "$homie": "3.0.1",
        "$nodes": "relay[]",
        "relay/$array": "0-1",
        "relay/$type": "switch",
        "relay/$properties": "on",
        "relay_1/$name": "Pump",
        "relay/on/$datatype": "boolean",
        "relay/on/$settable": "true",
        "$state": "ready",
    }
    device = device_in(tell(say, relays, "homie/relays"))
    assert [(one.part.id, one.part.name) for one in device.parts[:-1]] == [("relay_0", ""), ("relay_1", "Pump")]
    assert device.parts[1].part.writes == ("homie/relays/relay_1/on/set",)
    (named,) = say("homie/relays/relay/$name", "Relay")
    assert [one.part.name for one in device_in((named,)).parts[:-1]] == ["Relay 0", "Pump"]


def test_an_illegal_property_is_left_out(homie: Homie, say: Say) -> None:
    device = device_in(tell(say, {**LAMP, "light/color/$format": "cmyk"}))
    assert {one.name for one in device.parts[0].part.capabilities} == {"on_off"}
    assert homie.reader.ignored == 1


@pytest.mark.parametrize(
    ("attribute", "value"), [("$state", "on"), ("$homie", "5.0"), ("$homie", "x"), ("$name", "x" * 5000)]
)
def test_an_illegal_attribute_is_refused(homie: Homie, say: Say, attribute: str, value: str) -> None:
    with pytest.raises(WireError):
        say(f"{BASE}/{attribute}", value)
    assert homie.rejected == 1


def test_unfinished_devices_have_so_much_room(homie: Homie, say: Say) -> None:
    tell(say, LAMP)
    for number in range(2000):
        say(f"homie/x{number}/$name", "x")
    assert homie.reader.dropped == 1
    assert say(f"{BASE}/$state", "") != ()


def test_one_device_has_so_many_attributes(homie: Homie, say: Say) -> None:
    for number in range(3001):
        say(f"{BASE}/light/p{number}/$name", "x")
    assert homie.reader.dropped == 1


def test_retained_attributes_end_with_the_state(homie: Homie) -> None:
    filters = homie.filters()
    assert filters[-1] == "ebus/+/$state"
    for attribute in LAMP:
        assert any(topic_matches(one, f"{BASE}/{attribute}") for one in filters), attribute
    assert not any(topic_matches(one, f"{BASE}/light/on") for one in filters)
    assert not any(topic_matches(one, f"{BASE}/light/on/set") for one in filters)
