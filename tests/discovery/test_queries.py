"""Queries: the directory's sets and a look at each device say the same; the best comes first and says why."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tests.announcements import sighting_of
from tests.discovery.announcements import announce, part_of, tell

from homebot.conventions.device_classes import CONDITION_CLASSES
from homebot.conventions.units import sensor_type
from homebot.devices import KeyValue
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.devices.part import Capability, Part
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.terms import AreaIs, NameIs, Not, Query
from homebot.devices.value import Reading, Value
from homebot.discovery import DeviceIndex
from homebot.discovery.search.rank import rank, reasons
from homebot.messages import Time
from homebot.words.queries import parse_query


@pytest.fixture
def house() -> DeviceIndex:
    index = DeviceIndex(forget_after=1000.0)
    lamp = part_of("light", "on_off", "level", id="l", writes=("a",))
    desk = announce("a", lamp, ids=("id:desk",), name="Desk lamp", area="Study", facts={"model": "E27 bulb"})
    hall = announce("b", part_of("light", "on_off", id="l", writes=("b",)), ids=("id:hall",), name="Hall", area="Hall")
    plug = announce(
        "c",
        part_of("plug", "on_off", id="p", writes=("c",)),
        part_of("light", "on_off", id="led", writes=("d",), category="config"),
        part_of("x_battery", "battery", id="bat", category="diagnostic"),
        ids=("id:plug",),
        name="Plug at the desk",
        area="Study",
    )
    window = announce(
        "w", part_of("contact_sensor", "contact", id="c", tag="window"), ids=("id:w",), name="Fenster Küche"
    )
    door = announce("x", part_of("contact_sensor", "contact", id="c", tag="door"), ids=("id:x",), name="Front")
    blind = announce("y", part_of("window_covering", "position", id="c", writes=("y",)), ids=("id:y",), name="Blind")
    for one in (desk, hall, plug, window, door, blind):
        index.observe(one)
    for report in (
        tell(desk, "on_off", True, part="l"),
        tell(desk, "level", 70.0, part="l"),
        tell(hall, "on_off", False, part="l"),
        tell(plug, "on_off", True, part="p"),
        tell(plug, "battery", 12.0, part="bat"),
        tell(window, "contact", True, part="c"),
        tell(door, REACHABLE, False),
        tell(blind, "position", None, part="c"),
    ):
        index.report(report)
    return index


FOUND = {
    "category=config": {"plug_at_the_desk"},
    "category=diagnostic not in study": set(),
    "disputed": set(),
    "": {"desk_lamp", "hall", "plug_at_the_desk", "fenster_kuche", "front", "blind"},
    "light": {"desk_lamp", "hall"},
    "Lamps": {"desk_lamp", "hall"},
    "on lights": {"desk_lamp"},
    "lights not on": {"hall"},
    "on": {"desk_lamp", "plug_at_the_desk"},
    "light and dimmable in study": {"desk_lamp"},
    "level > 50": {"desk_lamp"},
    "level > 70": set(),
    "in study": {"desk_lamp", "plug_at_the_desk"},
    "in study not light": {"plug_at_the_desk"},
    "window": {"fenster_kuche", "blind"},
    "open windows": {"fenster_kuche"},
    "kuche": {"fenster_kuche"},
    "küche": {"fenster_kuche"},
    "desk": {"desk_lamp", "plug_at_the_desk"},
    "model=e27": {"desk_lamp"},
    "with battery": {"plug_at_the_desk"},
    "battery < 20": {"plug_at_the_desk"},
    "battery": {"plug_at_the_desk"},
    "offline": {"front"},
    "closed": set(),
    "position = 0 or position != 0": set(),
    "unconfirmed": {"front"},
    "fresh": {"desk_lamp", "hall", "plug_at_the_desk", "fenster_kuche", "blind"},
    "gateway=mqtt type=plug": {"plug_at_the_desk"},
    "gateway=other": set(),
    "convention=homeassistant and id=hall": {"hall"},
    "sensor not door": {"fenster_kuche"},
    "nosuchthing": set(),
}


@pytest.mark.parametrize(("text", "expected"), FOUND.items(), ids=[text or "all" for text in FOUND])
def test_a_query_finds_what_it_says(house: DeviceIndex, text: str, expected: set[str]) -> None:
    """By sets, and by a look at each device."""
    query = parse_query(text)
    assert house.find(query) == expected
    assert {one.id for one in house.devices() if fits(query, facets_of(one))} == expected


@pytest.mark.parametrize(("text", "expected"), [("fenstre", {"fenster_kuche"}), ("fenst", {"fenster_kuche"})])
def test_a_search_alone_guesses(house: DeviceIndex, text: str, expected: set[str]) -> None:
    """A trigger, a policy or a right for "Heated lamp" also was for the Heater lamp, and nothing said so."""
    query = parse_query(text)
    assert house.find(query) == expected
    assert not any(fits(query, facets_of(one)) for one in house.devices())


def test_a_changed_value_is_found_at_once(house: DeviceIndex) -> None:
    on = parse_query("on lights")
    assert house.find(on) == {"desk_lamp"}
    house.report(tell(announce("b"), "on_off", True, part="l", at=2))
    house.report(tell(announce("a"), "on_off", None, part="l", at=2))
    assert house.find(on) == {"hall"}


def test_the_best_comes_first_and_says_why(house: DeviceIndex) -> None:
    query = parse_query("desk")
    ranked = rank(query, house.find(query), house.postings)
    assert [one for _, one in ranked] == ["desk_lamp", "plug_at_the_desk"]
    assert reasons(query, "desk_lamp", house.postings) == ("its name has desk", "it reported recently")

    wrong = parse_query("dexk")
    house.find(wrong)
    assert reasons(wrong, "desk_lamp", house.postings)[0] == "dexk is a near match"


def test_each_kind_of_reason_is_told(house: DeviceIndex) -> None:
    query = parse_query("light in study with level level>50 model=e27")
    house.find(query)
    assert reasons(query, "desk_lamp", house.postings) == (
        "it is a light",
        "it is in study",
        "it has level",
        "level is 70",
        "its model is e27",
        "it reported recently",
    )
    offline = parse_query("contact")
    house.find(offline)
    assert "it is offline" in reasons(offline, "front", house.postings)


def test_what_is_disputed_is_found_until_it_is_settled(house: DeviceIndex) -> None:
    disputed = parse_query("disputed")
    house.observe(announce("z", part_of(id="z", writes=("c",)), ids=("id:evil",), name="Evil"))
    assert house.find(disputed) == {"evil"}
    house.observe(announce("c", ids=("id:plug",)).model_copy(update={"kind": "removed"}))
    assert house.find(disputed) == set()


names = st.sampled_from(["Desk lamp", "Dsk lamp", "Küche", "Kuche 2", "hall", "x"])
types = st.sampled_from(["light", "plug", "contact_sensor", "window_covering"])
steps = st.tuples(
    st.integers(0, 4),
    st.sampled_from(["announce", "remove", "live", "value", "reach"]),
    names,
    types,
    st.sampled_from(["", "window", "door"]),
    st.sampled_from([None, True, False, 0.0, 40.0, 80.0]),
)
questions: list[Query] = [parse_query(text) for text in FOUND] + [
    parse_query(text) for text in ("not (light or plug) in hall", "level<=40 or on", "x hall or kuche")
]
questions += [AreaIs("hall"), AreaIs("ha"), NameIs("desk lamp"), NameIs("desk"), Not(NameIs("t0"))]


@given(st.lists(steps, max_size=25))
def test_the_sets_always_say_what_a_look_at_each_device_says(
    told: list[tuple[int, str, str, str, str, bool | float | None]],
) -> None:
    index = DeviceIndex(forget_after=50.0)
    for at, (number, what, name, service_type, tag, value) in enumerate(told):
        _do(index, at, number, what, name, service_type, tag, value)
        if at % 7 == 0:
            index.find(questions[at % len(questions)])
    devices = index.devices()
    for query in questions:
        assert index.find(query) == {one.id for one in devices if fits(query, facets_of(one))}


def _do(
    index: DeviceIndex,
    at: int,
    number: int,
    what: str,
    name: str,
    service_type: str,
    tag: str,
    value: bool | float | None,  # noqa: FBT001 - a drawn value
) -> None:
    stamp, key = Time.from_seconds(float(at)), f"homeassistant:{number}"
    if what in {"value", "reach"}:
        capability = "on_off" if isinstance(value, bool) else "level"
        part, capability = ("", REACHABLE) if what == "reach" else ("p", capability)
        reading = Reading(part=part, capability=capability, value=Value.of(value))
        index.report(
            Report(gateway="mqtt", key=key, readings=(reading,), address="a", retained=False, received_at=stamp)
        )
        return
    one = Part(
        id="p",
        service_type=service_type,
        tag=tag,
        capabilities=(Capability(name="on_off", settable=True), Capability(name="level")),
    )
    index.observe(
        sighting_of(
            key,
            one,
            kind="removed" if what == "remove" else "updated",
            name=name,
            metadata=(KeyValue(key="model", value=name),),
            convention="homeassistant",
            identifiers=(f"id:device-{number // 2}",),
            area=name,
            confirmed=what == "live",
            at=at,
            lasts=10.0,
        )
    )
    index.expire(float(at))


SPOKEN = {
    "carbon_monoxide_alarm": ("smoke alarm",),
    "contact": ("door", "window"),
    "occupancy": ("motion", "presence", "motion sensor"),
    "smoke": ("smoke detector",),
    "water_leak": ("leak", "flood sensor"),
}


STATES = {"battery_low", "unlocked"}
"""Classes whose words are states themselves, without on or off."""


@pytest.mark.parametrize("capability", sorted(CONDITION_CLASSES.keys() - STATES))
def test_on_means_what_a_sensor_detects(capability: str) -> None:
    """It was read as a switch, which no such sensor has."""
    sensor = announce("s", part_of(sensor_type(capability), capability, id="s"), ids=("id:s",), area="Cellar")
    index = DeviceIndex(forget_after=1000.0)
    index.observe(sensor)
    for value in (True, False):
        index.report(tell(sensor, capability, value, part="s"))
        for word in (capability.replace("_", " "), *SPOKEN.get(capability, ())):
            found = {state: fits_in_sets_too(index, f"{word} in cellar {state}") for state in ("on", "off")}
            assert found == {"on": value, "off": not value}, word


@pytest.mark.parametrize(
    ("kind", "text", "is_found"),
    [
        ("light", "hall motion light on", False),
        ("plug", "with occupancy on", False),
        ("occupancy_sensor", "motion on", True),
        ("occupancy_sensor", "hall motion not on", False),
    ],
)
def test_what_can_be_switched_is_asked_about_its_switch(kind: str, text: str, *, is_found: bool) -> None:
    """A lamp with a motion sensor is off although somebody is there; a sensor with a switch detects all the same."""
    index = DeviceIndex(forget_after=1000.0)
    both = announce("s", part_of(kind, "occupancy", "on_off", id="s"), ids=("id:s",), name="Hall motion light")
    index.observe(both)
    for name, value in (("occupancy", True), ("on_off", False)):
        index.report(tell(both, name, value, part="s"))
    assert fits_in_sets_too(index, text) is is_found


def fits_in_sets_too(index: DeviceIndex, text: str) -> bool:
    """Return whether a device matches, by the sets and by a look at it."""
    query = parse_query(text)
    found = bool(index.find(query))
    assert any(fits(query, facets_of(device)) for device in index.devices()) is found
    return found
