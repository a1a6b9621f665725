"""The sentences to pick for a routine: the grammar reads each, in each language, and each means one device alone."""

from collections.abc import Mapping, Sequence
from typing import Final

import pytest
from tests.apps.houses import hall
from tests.recorded_house import HOUSE, NOW, device, part

from homebot.devices import Device
from homebot.devices.device import DevicePart, State
from homebot.devices.part import Capability, Part
from homebot.devices.query.facets import facets_of
from homebot.devices.query.matching import fits
from homebot.devices.query.terms import lasting
from homebot.devices.value import Value
from homebot.errors import ServiceError
from homebot.features.routines import ROUTINE_SENTENCES, sentences
from homebot.features.routines.messages import ListRoutineSentences, RoutineSentencesRequest, RoutineSentencesResponse
from homebot.graph import Node
from homebot.testing import virtual_house_of
from homebot.words.conditions import Matches, read_condition
from homebot.words.device_words import DeviceWords
from homebot.words.house_queries import WordsQuery
from homebot.words.steps import Do, SendRobot, WaitUntil, read_step
from homebot.words.triggers import Becomes, PersonMoves, Press, RobotArrival, read_trigger

_MODES: Final = Capability(name="option", settable=True, options=("day", "night"))
HOUSEHOLD: Final[Sequence[Device]] = (
    *HOUSE,
    device("Nursery", part("temperature_sensor", "temperature", "humidity"), area="nursery"),
    device("Washer", part("plug", "on_off", "power")),
    device("Kitchen window", part("contact_sensor", "contact"), area="kitchen"),
    device("Robbie", part("robotic_vacuum_cleaner", "vacuum")),
    device("Rosie", part("x_robot", "place")),
    device("Mode", DevicePart(id="", part=Part(id="", service_type="x_setting", capabilities=(_MODES,)), routes=())),
    device("Lamp {of you}", part("light", "on_off")),
    device("Alarm 22:30", part("light", "on_off", "level")),
    device("Lamp 5", part("light", "on_off", "level")),
    device("Fenster links", part("contact_sensor", "contact")),
)
WORDS: Final = DeviceWords(HOUSEHOLD)
LANGUAGES: Final = ("en", "de", "fr", "es", "it", "nl")
BY_NAME: Final = {one.name: one for one in HOUSEHOLD}
UNNAMED: Final = {"Twin", "TWIN", '"quoted" lamp', "Lamp {of you}"}
"""No sentence can have their names, or these are not clear."""


def of(name: str, language: str = "en") -> RoutineSentencesResponse:
    return sentences.of_device(WORDS, BY_NAME[name], language)


def of_house(language: str = "en", *, has_place: bool = True) -> RoutineSentencesResponse:
    return sentences.of_house(WORDS, language, ["Film"], ["Good night"], has_place=has_place)


def plain(text: str) -> str:
    return text.replace("{", "").replace("}", "")


def meant(read: object) -> list[str]:
    """The devices that a trigger or state means in this house, where names count, whatever its value."""
    assert isinstance(read, Becomes | PersonMoves | Press)
    words = "" if isinstance(read, PersonMoves) else read.words
    query = WordsQuery(words, HOUSEHOLD).query if words else read.query
    return [one.name for one in HOUSEHOLD if fits(lasting(query), facets_of(one))]


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_sentence_of_a_device_is_read_and_means_it_alone(language: str) -> None:
    count = 0
    for name in BY_NAME:
        found = of(name, language)
        for text in map(plain, found.when):
            trigger = read_trigger(text)
            robot = trigger.robot if isinstance(trigger, RobotArrival) else ""
            assert robot == name.casefold() if robot else meant(trigger) == [name], text
        for text in map(plain, found.conditions):
            condition = read_condition(text)
            assert isinstance(condition, Matches), text
            assert meant(condition.state) == [name], text
        for text in map(plain, found.steps):
            match read_step(text):
                case Do(target=target):
                    known = {name, WORDS.reference(BY_NAME[name].id), BY_NAME[name].id}
                    assert target.partition("#")[0] in known, text
                case WaitUntil(state=state):
                    assert meant(state) == [name], text
                case SendRobot(robot=robot):
                    assert robot == name.casefold(), text
                case step:
                    pytest.fail(f"{text} is {step}")
        assert bool(found.when or found.steps) is (name not in UNNAMED), name
        count += len((*found.when, *found.conditions, *found.steps))
    assert count > 300


@pytest.mark.parametrize("language", LANGUAGES)
def test_each_sentence_of_the_house_is_read_and_has_its_values_in_braces(language: str) -> None:
    found = of_house(language)
    for texts, read in ((found.when, read_trigger), (found.conditions, read_condition), (found.steps, read_step)):
        assert texts
        for text in texts:
            read(plain(text))
    assert sum("{22:30}" in text for text in found.when) == 10
    assert sum("{5}" in text or "{…}" in text for text in found.steps) == 2


@pytest.mark.parametrize(
    ("device", "text"),
    [
        ("Hall motion", "Hall motion occupied"),
        ("Hall motion", "Hall motion clear for {5}m"),
        ("Hall lamp two", "Hall lamp two on"),
        ("Nursery", "temperature of Nursery below {20} °C"),
        ("Kitchen window", "Kitchen window open for {5}m"),
        ("Washer", "power of Washer below {20} W for {5}m"),
        ("Anna", "Anna leaves"),
        ("Household", "everybody has left"),
        ("Hall button", "Hall button press double"),
        ("Sofa pad", "Sofa pad#2 press single"),
        ("Front door lock", "Front door lock unlocked"),
        ("Robbie", "Robbie docked"),
        ("Alarm 22:30", 'name="Alarm 22:30" on for {5}m'),
        ("Lamp 5", "Lamp 5 off for {5}m"),
        ("Rosie", "Rosie arrives in kitchen"),
    ],
)
def test_what_people_commonly_want_to_start_a_routine_can_be_picked(device: str, text: str) -> None:
    assert text in of(device).when


@pytest.mark.parametrize(
    ("device", "text"),
    [
        ("Hall lamp two", "Hall lamp two on"),
        ("Hall lamp two", "Hall lamp two toggle"),
        ("Hall lamp", "Hall lamp {50} %"),
        ("notify: open the lock", 'wait until name="notify: open the lock" on, at most {30}m'),
        ("Bath heating", "Bath heating {20} °C"),
        ("Blind", "Blind close"),
        ("Front door lock", "Front door lock lock"),
        ("Double relay", "double_relay#r off"),
        ("Hall motion", "wait until Hall motion clear for {5}m, at most {30}m"),
        ("Lamp 5", "Lamp 5 {50} %"),
        ("Rosie", "Rosie go to dock"),
    ],
)
def test_what_people_commonly_want_to_do_can_be_picked(device: str, text: str) -> None:
    assert text in of(device).steps


@pytest.mark.parametrize(
    ("kind", "texts"),
    [
        ("when", {"{22:30} on weekdays", "sunset - {30}m", "sunrise", "every {30}m"}),
        ("conditions", {"sun is down", "between {22:30} and {06:30}", "on weekends", "nobody in hall"}),
        ("steps", {"wait {5}m", "undo", "notify {…}", "scene Film", "run routine Good night"}),
    ],
)
def test_times_the_sun_rooms_scenes_and_routines_can_be_picked(kind: str, texts: set[str]) -> None:
    assert texts <= set(getattr(of_house(), kind))


@pytest.mark.parametrize(
    ("language", "expected"),
    [
        ("de", {"Kitchen window geht auf", "Kitchen window ist seit {5} Minuten offen"}),
        ("fr", {"Kitchen window est ouverte depuis {5} minutes"}),
        ("es", {"Kitchen window está abierta desde hace {5} minutos"}),
        ("it", {"Kitchen window è aperta da {5} minuti"}),
        ("nl", {"Kitchen window staat al {5} minuten open"}),
        ("xx", {"Kitchen window open", "Kitchen window open for {5}m"}),
    ],
)
def test_a_sentence_is_in_the_language_that_is_asked_for(language: str, expected: set[str]) -> None:
    assert expected <= set(of("Kitchen window", language).when)


@pytest.mark.parametrize("language", LANGUAGES[1:])
@pytest.mark.parametrize(
    "name", ["Hall motion", "Kitchen window", "Washer", "Nursery", "Hall button", "Anna", "Household"]
)
def test_what_starts_most_routines_is_said_in_each_language(name: str, language: str) -> None:
    assert set(of(name, language).when).isdisjoint(of(name).when)
    assert len(of(name, language).when) == len(of(name).when)


@pytest.mark.parametrize("language", LANGUAGES[1:])
def test_no_sentence_is_in_two_languages(language: str) -> None:
    """In German it was "wähle = day, at most 30m für wait until Mode"."""
    english = set(of("Mode").steps)
    assert {text for text in of("Mode", language).steps if "wait until" in text} <= english
    assert "Mode option day" in english - set(of("Mode", language).steps)


def test_the_sun_is_offered_only_in_a_home_whose_place_is_known() -> None:
    found = of_house(has_place=False)
    assert not [text for text in (*found.when, *found.conditions) if "sun" in text.replace("on sun", "")]


def test_what_people_set_and_press_starts_nothing_by_its_number() -> None:
    """Else a lamp had eight more sentences about its level, and as many about its white."""
    assert not [text for text in of("Hall lamp").when if "level" in text]
    assert not [text for text in of("Blind").steps if "position" in text]
    assert of("Bath heating").when == ()


def test_a_number_begins_with_the_present_value() -> None:
    state = State(part="", capability="temperature", value=Value.of(17.26), since=NOW, told_at=NOW, live=True)
    found = sentences.of_device(WORDS, BY_NAME["Nursery"].model_copy(update={"states": (state,)}), "en")
    assert "temperature of Nursery below {17.5} °C" in found.when


@pytest.mark.virtual_time
@pytest.mark.slow
@pytest.mark.rooms("homeassistant", "scenes")
async def test_the_service_speaks_the_language_of_the_house_unless_another_is_asked_for() -> None:
    tables: Mapping[str, object] = {
        "home": {"zone": "UTC", "language": "de"},
        "scenes": [{"name": "Film", "values": {"hall_lamp": "on"}}],
        "routines": [{"name": "Good night", "when": ["22:00"], "do": ["all lights off"]}],
    }
    async with virtual_house_of(world=hall(), config=tables) as house, Node(house.runtime.graph, "owner") as owner:
        client = owner.create_client(ListRoutineSentences, ROUTINE_SENTENCES.name)
        german = await client.call(RoutineSentencesRequest(device="hall_lamp"))
        assert "schalte hall_lamp ein" in german.steps
        assert "hall_lamp on" in (await client.call(RoutineSentencesRequest(device="hall_lamp", language="en"))).steps
        assert {"Szene Film", "starte Routine Good night"} <= set((await client.call(RoutineSentencesRequest())).steps)
        with pytest.raises(ServiceError, match="device: there is no device 'gone'"):
            await client.call(RoutineSentencesRequest(device="gone"))
