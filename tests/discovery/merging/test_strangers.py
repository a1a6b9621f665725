"""A stranger's announcement with the identifiers of a dangerous device takes nothing from its dangers.

Any program that a broker lets publish below a topic of its own can make one, in the convention of its choice.
"""

import pytest
from tests.discovery.announcements import announce, only_device, part_of, tell

from homebot.devices import Sighting
from homebot.devices.always_ask import always_asks, waits_for_approval
from homebot.devices.part import Capability, Category, Part
from homebot.discovery import DeviceIndex, OwnerFacts
from homebot.places import NO_PLACES
from homebot.words.queries import parse_query
from homebot.words.rights import read_scope

MAC = "mac:aabbccddeeff"
CONVENTIONS = ("homie", "tasmota", "thing")


def index_of(*sightings: Sighting) -> DeviceIndex:
    index = DeviceIndex(forget_after=1000.0, owner=OwnerFacts("Home", NO_PLACES, 5.0))
    for number, one in enumerate(sightings):
        index.observe(one, float(number))
    return index


def relay(name: str = "", kind: str = "switch", *, at: str = "gate", advertised: str = "") -> Part:
    return part_of(kind, "on_off", id="r", name=name, writes=(f"{at}/set",), advertised=advertised)


def oven(hottest: float, at: str) -> Part:
    heat = Capability(name="heating_setpoint", settable=True, unit="°C", bounds=(5.0, hottest))
    return Part(id="r", service_type="thermostat", capabilities=(heat,), writes=(f"{at}/set",))


def button(name: str, at: str, category: Category = "") -> Part:
    return part_of("x_setting", "push", id="r", name=name, writes=(f"{at}/set",), category=category)


DANGERS = {
    "the deed of its button": (button("Open gate", "gate"), button("Open gate", "evil", "config"), "Box", {}),
    "the deed of its only button": (button("", "gate"), button("", "evil", "config"), "Open gate", {}),
    "its model": (relay(), relay(at="evil"), "Box", {"model": "Garage door opener"}),
    "its name, to one of a setting": (relay(), relay(kind="x_setting", at="evil"), "Garage door", {}),
    "its name, to one of a siren": (relay(), part_of("x_sensor", "state"), "Garage door", {}),
    "the name of its part": (relay("Garage door"), relay("Lamp", at="evil"), "Box", {}),
    "what it calls itself": (relay(kind="x_unknown", advertised="oven"), relay("", "x_unknown", at="evil"), "Box", {}),
    "how hot it gets": (oven(110.0, "gate"), oven(30.0, "evil"), "Box", {}),
}


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("is_first", [False, True])
@pytest.mark.parametrize("danger", DANGERS, ids=lambda one: one)
def test_what_joins_a_dangerous_device_does_not_hide(danger: str, is_first: bool, convention: str) -> None:  # noqa: FBT001
    """Otherwise every program might command it, without an approval."""
    part, other, name, facts = DANGERS[danger]
    true = announce("gate", part, ids=(MAC,), name=name, facts=facts)
    evil = announce("evil", other, convention=convention, ids=(MAC,), name="Siren", facts={"model": "Siren"})
    device = only_device(index_of(*((evil, true) if is_first else (true, evil))))
    ways = [part for part in device.parts if any(route.key == true.key for route in part.routes)]
    assert ways
    assert all(always_asks(device, part) for part in ways)
    assert waits_for_approval(device)


@pytest.mark.parametrize("convention", CONVENTIONS)
def test_a_denied_way_to_a_gate_does_not_describe_it(convention: str) -> None:
    """A lamp on the topic of the gate has no way there, so that only the gate's announcement says what that is."""
    lamp = announce("evil", relay("Lamp", "x_setting"), convention=convention, ids=(MAC,), name="Box")
    device = only_device(index_of(lamp, announce("gate", relay("Gate"), ids=(MAC,), name="Box")))
    told = [part for part in device.parts if any(route.topics == ("gate/set",) for route in part.routes)]
    assert told
    assert all(always_asks(device, part) for part in told)


@pytest.mark.parametrize("convention", ["homeassistant", *CONVENTIONS])
def test_what_joins_an_approved_lock_gives_it_no_name_and_no_place_in_any_way(convention: str) -> None:
    """A right to the lock in the shed, or called so, would be one to this lock."""
    index = index_of(
        announce("door", part_of("door_lock", "lock", id="l", writes=("door/set",)), ids=(MAC,), name="Door")
    )
    index.places.approve("door", 1.0)
    facts = {"aliases": "Shed bolt", "tags": "mine", "position": "1,2"}
    index.observe(
        announce(
            "evil", part_of("x_sensor"), convention=convention, ids=(MAC,), name="Shed lock", area="Shed", facts=facts
        )
    )
    device = only_device(index)
    assert (device.name, device.names, device.area, device.tags) == ("Door", ("Door",), "", ())
    assert not [one for one in device.facts if one.name == "position"]
    for query in ('name="Shed lock"', "name=shed", 'name="Shed bolt"', "in shed", "shed"):
        assert not index.find(parse_query(query))
    for right in ('act: name="Shed lock"', "act: name=Shed", "act: lock in shed"):
        assert not read_scope((right,)).may_command(device, device.parts[0], asks=True, is_harmless=False)


def test_what_joins_an_approved_device_asks_by_its_own_model() -> None:
    """Only its names and places are not believed: the danger that it states is its own."""
    index = index_of(announce("gate", relay("Gate"), ids=(MAC,), name="Box"))
    index.places.approve(only_device(index).id, 1.0)
    other = part_of("switch", "on_off", id="relay_2", writes=("esp/set",))
    index.observe(announce("esp", other, ids=(MAC,), name="Box", facts={"model": "Garage door opener"}), 2.0)
    device = only_device(index)
    assert all(always_asks(device, part) for part in device.parts)
    assert not index.find(parse_query('model="Garage door opener"'))


@pytest.mark.parametrize("convention", CONVENTIONS)
@pytest.mark.parametrize("is_first", [False, True])
def test_a_stranger_gets_no_commands_before_its_first_report(convention: str, is_first: bool) -> None:  # noqa: FBT001
    """Its state topic says nothing, so that each command by it would be without an answer."""
    lamp = part_of("light", "on_off", id="l", reads=("kitchen_lamp/state",), writes=("kitchen_lamp/set",))
    evil = part_of("light", "on_off", "color_temperature", id="e", reads=("evil/state",), writes=("evil/set",))
    true = announce("lamp", lamp, ids=(MAC,), name="Lamp")
    stranger = announce("evil", evil, convention=convention, ids=(MAC,), name="Lamp")
    index = index_of(*((stranger, true) if is_first else (true, stranger)))
    for told, ways in ((), {"lamp", "evil"}), ((true,), {"lamp"}), ((stranger,), {"lamp", "evil"}):
        for one in told:
            index.report(tell(one, "on_off", value=True, part=one.parts[0].id), 3.0)
        device = only_device(index)
        keys = {route.key.rpartition(":")[2] for part in device.parts for route in part.routes}
        assert keys == ways
        assert any("before its first report" in one for one in device.conflicts) is (len(ways) == 1)


@pytest.mark.parametrize("is_first", [False, True])
def test_what_a_stranger_adds_on_the_devices_own_command_topic_is_no_part_before_its_report(*, is_first: bool) -> None:
    """Each command to the lamp ended with a refusal of this part, which may not command there."""
    lamp = part_of("light", "on_off", id="l", reads=("kitchen_lamp/state",), writes=("kitchen_lamp/set",))
    evil = part_of("light", "on_off", "level", id="e", reads=("evil/state",), writes=("kitchen_lamp/set",))
    true = announce("kitchen_lamp", lamp, ids=(MAC,), name="Lamp", on="homeassistant/light/kitchen_lamp/config")
    stranger = announce("evil", evil, ids=(MAC,), name="Lamp", on="homeassistant/light/evil/config")
    index = index_of(*((stranger, true) if is_first else (true, stranger)))
    for said, parts in (true, ["l"]), (stranger, ["l", "e"]):
        index.report(tell(said, "on_off", value=True, part=said.parts[0].id), 3.0)
        device = only_device(index)
        assert sorted(part.id for part in device.parts) == sorted(parts)
        assert all("where another announcement" in conflict for conflict in device.conflicts)


@pytest.mark.parametrize("is_last", [False, True])
@pytest.mark.parametrize("at", ["evil", "evil/aabbccddeeff"])
@pytest.mark.parametrize("place", ["x17", "aabbccddeeff"])
def test_a_silent_stranger_on_the_command_topic_of_a_lamp_takes_nothing_from_it(
    place: str, at: str, *, is_last: bool
) -> None:
    """No place named the topic, so that both were refused; or a command was sent to both, and one did not answer."""
    lamp = part_of("light", "on_off", id="l", reads=("kitchen_lamp/state",), writes=("kitchen_lamp/set",))
    evil = part_of("light", "on_off", "level", id="e", reads=("evil/state",), writes=("kitchen_lamp/set",))
    true = announce("lamp", lamp, ids=(MAC,), name="Lamp", on=f"homeassistant/light/{place}/config")
    stranger = announce("evil", evil, ids=(MAC,), name="Lamp", on=f"homeassistant/light/{at}/config")
    index = index_of(*((true,) if is_last else (stranger, true)))
    index.report(tell(true, "on_off", value=True, part="l"), 3.0)
    if is_last:
        index.observe(stranger, 4.0)
    (part,) = only_device(index).parts
    assert [(route.key, route.part) for route in part.routes] == [(true.key, "l")]
    assert [conflict for conflict in only_device(index).conflicts if stranger.key in conflict]
    assert not [conflict for conflict in only_device(index).conflicts if conflict.startswith(true.key)]


def test_a_report_does_not_give_a_lamp_the_topic_of_a_silent_lock() -> None:
    """Its command might be the one that unlocks."""
    lock = part_of("door_lock", "lock", id="l", reads=("door/state",), writes=("door/set",))
    true = announce("lock", lock, ids=(MAC,), on="homeassistant/lock/x17/config")
    lamp = part_of("light", "on_off", id="e", reads=("evil/state",), writes=("door/set",))
    evil = announce("evil", lamp, ids=(MAC,), on="homeassistant/light/evil/config")
    index = index_of(true, evil)
    index.report(tell(evil, "on_off", value=True, part="e"), 3.0)
    assert not [route for part in only_device(index).parts for route in part.routes if route.key == evil.key]


@pytest.mark.parametrize("is_first", [False, True])
@pytest.mark.parametrize(
    ("kind", "can", "is_listed"),
    [("light", "color_temperature", False), ("fan", "on_off", False), ("door_lock", "lock", True)],
)
def test_the_part_of_a_stranger_is_listed_once_it_has_reported(
    *, kind: str, can: str, is_listed: bool, is_first: bool
) -> None:
    """A plug was found as a light, a fan and their handles, with values that it does not have; dangers count."""
    true = announce("plug", part_of("plug", "on_off", id="p", reads=("plug/state",), writes=("plug/set",)), ids=(MAC,))
    added = part_of(kind, can, id="e", reads=("evil/state",), writes=("evil/set",))
    evil = announce("evil", added, convention="homie", ids=(MAC,))
    index = index_of(*((evil, true) if is_first else (true, evil)))
    index.report(tell(true, "on_off", value=True, part="p"), 3.0)
    for is_there in (is_listed, True):
        device = only_device(index)
        assert [part.part.service_type for part in device.parts if part.part.service_type != kind] == ["plug"]
        assert (kind in device.service_types, len(device.parts)) == (is_there, 1 + is_there)
        assert bool(index.find(parse_query(f"type={kind}"))) is is_there
        assert device.service_type == ("plug" if not is_there else device.service_type)
        index.report(tell(evil, can, value=5.0, part="e"), 4.0)
