"""Words that are exactly the name of something mean that alone, wherever they are written."""

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from tests.call_counts import calls

from homebot.devices import Device, DevicePart
from homebot.devices.device import State
from homebot.devices.device_types import wanted_types
from homebot.devices.part import Capability, Part
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.term_messages import query_terms, read_terms
from homebot.devices.query.terms import NameIs, Query
from homebot.devices.value import PlainValue, Value
from homebot.discovery.search.columns import StoredValue
from homebot.discovery.search.postings import Postings
from homebot.discovery.search.unknown_words import explain_result
from homebot.messages.builtin_interfaces import Time
from homebot.places import HousePlan
from homebot.support.folding import fold
from homebot.words.conditions import Matches, read_condition
from homebot.words.exact_queries import parse_cautious_query
from homebot.words.house_queries import WordsQuery
from homebot.words.queries import parse_query
from homebot.words.triggers import Becomes, read_trigger

NOW = Time(sec=1, nanosec=0)
WORDS = (
    *(
        "Treppe",
        "unten",
        "unter",
        "unten",
        "Dach",
        "TV",
        "lamp",
        "Lamps",
        "door",
        "bell",
        "Küche",
        "kitchen",
        "2",
        "23",
    ),
    *("motion", "heating", "battery", "temperature", "Garage", "switch", "the", "Left", "Lift"),
)
NAMES = st.lists(st.sampled_from((*WORDS, "open", "low")), max_size=2).flatmap(
    lambda before: st.sampled_from(WORDS).map(lambda last: " ".join([*before, last]))
)


def plug(number: int, name: str, *, is_on: bool, area: str = "") -> Device:
    return device(number, name, "plug", "on_off", is_on, area=area)


def device(number: int, name: str, kind: str, capability: str, value: PlainValue, *, area: str = "") -> Device:
    part = Part(id="", service_type=kind, capabilities=(Capability(name=capability, settable=True),))
    state = State(part="", capability=capability, value=Value.of(value), since=NOW, told_at=NOW, live=True)
    return Device(
        id=f"id{number}",
        name=name,
        service_type=kind,
        parts=(DevicePart(id="", part=part, routes=()),),
        endpoints=(),
        metadata=(),
        states=(state,),
        area=area,
        first_seen=NOW,
        last_seen=NOW,
        expires=NOW,
        freshness="fresh",
    )


def power_strip(named: dict[str, bool], kind: str) -> Device:
    """A device with a part for each name, which is on or off."""
    one = device(0, "strip", kind, "on_off", False)
    (part,), (state,) = one.parts, one.states
    parts, states = [], []
    for number, (name, is_on) in enumerate(named.items()):
        named_part = part.part.model_copy(update={"id": f"p{number}", "name": name})
        parts.append(part.model_copy(update={"id": f"p{number}", "part": named_part}))
        states.append(state.model_copy(update={"part": f"p{number}", "value": Value.of(is_on)}))
    return one.model_copy(update={"parts": tuple(parts), "states": tuple(states)})


def directory(devices: list[Device]) -> Postings:
    postings = Postings()
    for one in devices:
        postings.put(
            facets_of(one),
            [
                (
                    state.part,
                    one.service_type,
                    state.capability,
                    StoredValue(state.value, state.value.plain(), NOW, NOW, live=True),
                )
                for state in one.states
            ],
        )
    return postings


def found(postings: Postings, text: str) -> set[str]:
    return set(postings.find(parse_query(text, lambda query: bool(postings.find(query)))))


def followed(devices: list[Device], text: str) -> set[str]:
    query = WordsQuery(text, devices).query
    return matching(devices, query)


def matching(devices: list[Device], query: Query) -> set[str]:
    return {one.id for one in devices if fits(query, facets_of(one))}


@given(st.lists(NAMES, min_size=1, max_size=4, unique_by=fold), st.integers(0, 15))
def test_commands_searches_triggers_conditions_and_bans_mean_the_device_with_the_name(
    names: list[str], on: int
) -> None:
    devices = [plug(number, name, is_on=bool(on >> number & 1)) for number, name in enumerate(names)]
    postings = directory(devices)
    for one in devices:
        meant = {one.id} if one.states[0].value.plain() else set()
        text = f"{one.name} on"
        assume(fold(text) not in map(fold, names))
        trigger, condition = read_trigger(text), read_condition(f"not {text}")
        assert isinstance(trigger, Becomes)
        assert isinstance(condition, Matches)
        assert postings.find(NameIs(fold(one.name))) == {one.id}  # as a command does
        assert found(postings, one.name) == {one.id}
        for words in (text, f"is the {one.name} on?", trigger.words, condition.state.words):
            assert found(postings, words) == followed(devices, words) == meant, words
        assert meant <= matching(devices, parse_cautious_query(text))


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("(tv) on", "tv"),
        ("not (heater off)", "heater"),
        ("lamp (old) on", "lamp (old)"),
        ("(salt or pepper on)", "salt or pepper"),
    ],
)
def test_a_ban_with_brackets_means_names_in_and_around_them(text: str, name: str) -> None:
    """It was refused: a name ended outside the bracket in which it began."""
    devices = [plug(number, one, is_on=True) for number, one in enumerate((name, "kettle"))]
    assert "id0" in matching(devices, parse_cautious_query(text)) & found(directory(devices), text)


@given(st.lists(NAMES, min_size=1, max_size=4))
def test_searches_triggers_and_conditions_mean_the_room_with_the_name(rooms: list[str]) -> None:
    """Turning off the lights of ``Flur`` turned off those of ``Flur oben`` too."""
    devices = [plug(number, f"plug {number}", is_on=True, area=room) for number, room in enumerate(rooms)]
    postings = directory(devices)
    for one in devices:
        meant = {other.id for other in devices if fold(other.area) == fold(one.area)}
        text = f'plugs on in "{one.area}"'
        trigger, condition = read_trigger(text), read_condition(f"not {text}")
        assert isinstance(trigger, Becomes)
        assert isinstance(condition, Matches)
        for words in (text, trigger.words, condition.state.words):
            assert found(postings, words) == followed(devices, words) == meant, words
    live = WordsQuery(f'plugs in "{rooms[0]}"')
    for one in devices:
        live.record(one)
    for one in devices:
        live.record(one, is_gone=True)
    assert live.query == parse_query(f'plugs in "{rooms[0]}"')


def test_a_name_of_a_type_means_its_device_and_in_a_room_the_type_as_well() -> None:
    devices = [
        plug(1, "TV", is_on=True, area="living"),
        plug(2, "lamp", is_on=True, area="living"),
        plug(3, "hall plug", is_on=True, area="hall"),
        plug(4, "hall up plug", is_on=True, area="hall up"),
    ]
    postings = directory(devices)
    for text, meant in {
        "tv on": {"id1"},
        "on tv": {"id1"},
        "tv on or hall plug on": {"id1", "id3"},
        "plugs": {"id1", "id2", "id3", "id4"},
        "tv in living": {"id1"},
        "tv in hall": set(),
        "lamp level > 5": set(),  # it has none, so the type is meant
        "hall plug in hall": {"id3"},
        "what is on in the living?": {"id1", "id2"},
        "plugs in hal": set(),
        "plugs in hall": {"id3"},
        "plugs in hall up": {"id4"},
        "hall up plug in hall": set(),
        "which plugs are on in the hall?": {"id3"},
    }.items():
        assert found(postings, text) == followed(devices, text) == meant, text


@given(st.lists(NAMES, min_size=1, max_size=3, unique_by=fold), st.integers(0, 7), st.sampled_from(["plug", "light"]))
def test_a_part_that_is_called_like_a_type_that_it_is_not_is_meant_by_that_name(
    names: list[str], on: int, kind: str
) -> None:
    """``tv on`` found no strip with the plug TV, and ``not tv on`` held while it was on."""
    strip = power_strip({name: bool(on >> number & 1) for number, name in enumerate(names)}, kind)
    postings = directory([strip])
    for number, name in enumerate(names):
        if not (wanted := wanted_types(name)) or kind in wanted:
            continue
        for text, is_meant in ((f"{name} on", bool(on >> number & 1)), (f"{name} off", not on >> number & 1)):
            condition = read_condition(f"not {text}")
            assert isinstance(condition, Matches)
            for words in (text, condition.state.words):
                assert bool(found(postings, words)) == bool(followed([strip], words)) == is_meant, words
            query = WordsQuery(text, [strip]).query
            assert read_terms(query_terms(query)) == query
            parts = {one.part.name for one in strip.parts if fits(query, PartFacets(strip, one))}
            assert parts == ({name} if is_meant else set())
            assert not is_meant or matching([strip], parse_cautious_query(text))


def test_a_part_that_is_called_like_a_type_means_it_no_more_once_something_of_the_type_may_be_so() -> None:
    strip, television = power_strip({"TV": True}, "plug"), device(9, "Samsung", "video_player", "on_off", False)
    query, postings = WordsQuery("tv on", [strip]), directory([strip, television])
    assert matching([strip, television], query.query) == {"id0"}
    assert query.record(television)
    assert found(postings, "tv on") == matching([strip, television], query.query) == set()
    assert query.record(television, is_gone=True)
    assert matching([strip], query.query) == {"id0"}


def test_a_part_that_is_called_like_its_own_type_means_all_of_the_type() -> None:
    strip, lamp = power_strip({"Light": False}, "light"), device(9, "hall", "light", "on_off", True)
    postings = directory([strip, lamp])
    assert found(postings, "light on") == followed([strip, lamp], "light on") == {"id9"}


QUESTIONS = [
    device(1, "hall lamp", "light", "on_off", True, area="hall"),
    device(2, "desk lamp", "light", "on_off", False, area="study"),
    device(3, "front door", "contact_sensor", "contact", False, area="hall"),
    device(4, "front door lock", "door_lock", "lock", "locked", area="hall"),
    device(5, "cooler", "room_air_conditioner", "local_temperature", 21.0, area="study"),
    device(6, "hall eye", "occupancy_sensor", "occupancy", False, area="hall"),
    device(7, "Gate", "closure", "position", 0.0, area="garden"),
]


@pytest.mark.parametrize(
    ("text", "ids", "note"),
    [
        ("Which lights are on?", {"id1"}, ""),
        ("what is on in the hall", {"id1"}, ""),
        ("What's on in the hall?", {"id1"}, ""),
        ("which lights in the hall are on?", {"id1"}, ""),
        ("show me lights in the hall that are turned on, please", {"id1"}, ""),
        ("is the light in the study off", {"id2"}, ""),
        ("list all lights in the hall", {"id1"}, ""),
        ("is the front door locked?", {"id4"}, ""),
        ("is the front door open", set(), "none now; in another state there would be front door"),
        ("are there lights in the hall", {"id1"}, ""),
        ("temperature in study", {"id5"}, ""),
        ("temperature > 26 in study", set(), "no thermometer is there; write 'local temperature' for that of cooler"),
        ("local temperature > 20 in study", {"id5"}, ""),
        ("which lights are on in the study?", set(), "none now; in another state there would be desk lamp"),
        ("motion sensor in study", set(), "none is in study; there is in hall"),
        ("lights in kichen", set(), "no device is in 'kichen'; areas are garden, hall, study"),
        ("hall lamp locked", set(), "what is called so has no such value: hall lamp"),
        ("hall lanp", {"id1"}, "no device found has the word 'lanp'; these have similar ones"),
        ("somebody is home", set(), "nobody is known; add [people.NAME] with what tells where that person is"),
        ("is anything on?", {"id1"}, ""),
        ("is anything warm", set(), "no device has the word 'warm'"),
        ("kettle", set(), "no device has the word 'kettle'"),
    ],
)
def test_a_question_is_answered_by_devices_or_by_the_reason_for_none(text: str, ids: set[str], note: str) -> None:
    postings = directory(QUESTIONS)
    query = parse_query(text, lambda query: bool(postings.find(query)))
    assert postings.find(query) == ids
    assert explain_result(query, postings.find(query), postings, HousePlan("villa")) == note


@pytest.mark.parametrize("named", ["Lamp", "Socket"])
def test_to_learn_the_names_of_a_house_costs_in_proportion_to_its_devices(named: str) -> None:
    """Each of hundreds of routines learns them."""

    def learn(count: int) -> None:
        words = WordsQuery("lamp 7 on", [power_strip({named: True}, "plug")])
        for number in range(1, count):
            words.record(device(number, f"Lamp {number}", "light", "on_off", False))

    learn(200)  # fills the caches of words
    assert calls(lambda: learn(200)) < 2.2 * calls(lambda: learn(100))


def test_what_words_mean_follows_the_names_of_the_house() -> None:
    tv, lamp = plug(1, "TV", is_on=True), plug(2, "Lamp", is_on=True)
    query = WordsQuery("tv on")
    assert query.query == parse_query("tv on")
    assert (query.record(lamp), query.record(tv), query.record(tv)) == (False, True, False)
    assert matching([tv, lamp], query.query) == {"id1"}
    assert query.record(tv.model_copy(update={"name": "Telly"}))
    assert query.query == parse_query("tv on")
