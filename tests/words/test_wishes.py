"""What people type as a goal."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import replace

import pytest
from tests.call_counts import calls

from homebot.errors import UsageError
from homebot.words.mistakes import COLUMNS, mistake_in
from homebot.words.own_language import to_english
from homebot.words.wishes import (
    DOCK,
    GoalCondition,
    KnownNames,
    RobotCondition,
    RoomCondition,
    SceneCondition,
    StateCondition,
    read_wishes,
)

ROOMS = ("Hall", "Living", "Kitchen", "Office 2")
HOUSE = KnownNames(ROOMS, (*ROOMS, "upstairs"), ("rosie",), ("Film", "Good night"))


@pytest.mark.parametrize(
    ("text", "area", "is_lit"),
    [
        ("living lit", "Living", True),
        ('"Living" lit', "Living", True),
        ("the living room is dark", "Living", False),
        ("kitchen not lit", "Kitchen", False),
        ("no living room lit", "Living", False),
        ("not kitchen not lit.", "Kitchen", True),
        ("upstairs dark", "upstairs", False),
        ("house dark", "", False),
        ("make the living room bright", "Living", True),
    ],
)
def test_a_wish_for_light(text: str, area: str, *, is_lit: bool) -> None:
    (wish,) = read_wishes(text, HOUSE)
    assert isinstance(wish, RoomCondition)
    assert (wish.area, wish.is_lit) == (area, is_lit)


@pytest.mark.parametrize(
    ("text", "robot", "room", "is_not"),
    [
        ("rosie in kitchen", "rosie", "Kitchen", False),
        ("the robot is in the kitchen", "robot", "Kitchen", False),
        ("rosie goes to the living room", "rosie", "Living", False),
        ("rosie in office 2", "rosie", "Office 2", False),
        ('rosie in "office 2"', "rosie", "Office 2", False),
        ("rosie is not in the hall", "rosie", "Hall", True),
        ("not rosie in hall", "rosie", "Hall", True),
        ("rosie at the charging station", "rosie", DOCK, False),
        ("rosie is back in its dock", "rosie", DOCK, False),
        ("rosie docked", "rosie", DOCK, False),
        ("send rosie home", "rosie", DOCK, False),
        ("rosie is back home", "rosie", DOCK, False),
        ("send rosie to the kitchen", "rosie", "Kitchen", False),
        ("robot into the living room", "robot", "Living", False),
    ],
)
def test_a_wish_for_a_robot(text: str, robot: str, room: str, *, is_not: bool) -> None:
    (wish,) = read_wishes(text, HOUSE)
    assert isinstance(wish, RobotCondition)
    assert (wish.robot, wish.room, wish.is_not) == (robot, room, is_not)


@pytest.mark.parametrize(
    ("text", "target", "command"),
    [
        ("all lights off", "all lights", "off"),
        ("no lights on", "lights", "off"),
        ("no lights on in the hall", "lights in the hall", "off"),
        ("no lights on in the house", "lights", "off"),
        ("hall lamp is not on", "hall lamp", "off"),
        ("lights in kitchen on", "lights in kitchen", "on"),
        ("the front lock is locked", "front lock", "locked"),
        ("hall blinds closed", "hall blinds", "close"),
        ("vacuum docked", "vacuum", "dock"),
        ("living heat at 19 °C", "living heat", "19 °C"),
        ("living heat is set to 19", "living heat", "19"),
        ("living heat 19", "living heat", "19"),
        ("living lamp 40 %", "living lamp", "40 %"),
        ("living lamp on at 40 %", "living lamp", "40 %"),
        ("living lamp is red", "living lamp", "red"),
        ("office 2 lamp on", "office 2 lamp", "on"),
        ("turn on the kitchen lamp", "kitchen lamp", "on"),
        ("switch the hall lamp off", "hall lamp", "off"),
        ("dim the kitchen lamp to 40 %", "kitchen lamp", "40 %"),
        ("set living heat to 19 °C", "living heat", "19 °C"),
        ("the lights in the hall should be off", "lights in the hall", "off"),
        ("close the hall blinds", "hall blinds", "close"),
    ],
)
def test_a_wish_for_devices(text: str, target: str, command: str) -> None:
    (wish,) = read_wishes(text, HOUSE)
    assert isinstance(wish, StateCondition)
    assert (wish.target, wish.command, wish.area) == (target, command, False)


@pytest.mark.parametrize(
    ("text", "room", "command"),
    [
        ("kitchen at 19 °C", "Kitchen", "19 °C"),
        ("living room at 21 degrees", "Living", "21 degrees"),
        ("the living room at 21 °C", "Living", "21 °C"),
    ],
)
def test_a_wish_for_a_room_means_what_takes_it(text: str, room: str, command: str) -> None:
    assert read_wishes(text, HOUSE) == (StateCondition(text, room, command, area=True),)


@pytest.mark.parametrize("text", ["film", "scene film", "the film scene", "Film.", "start the film scene"])
def test_a_scene_is_a_wish(text: str) -> None:
    assert read_wishes(text, HOUSE) == (SceneCondition("scene Film", "Film"),)


def test_wishes_are_joined_and_the_last_subject_counts_on() -> None:
    wishes = read_wishes("front door closed and locked, kitchen lit AND good night", HOUSE)
    assert [one.text for one in wishes] == ["front door closed", "front door locked", "Kitchen lit", "scene Good night"]


@pytest.mark.parametrize(
    ("text", "wishes"),
    [
        ("kitchen and living lit", ["Kitchen lit", "Living lit"]),
        ("make the hall, kitchen and living room dark", ["Hall dark", "Kitchen dark", "Living dark"]),
        ("hall lamp and kitchen lamp on", ["hall lamp on", "kitchen lamp on"]),
        ("lights off in kitchen and hall", ["lights off in kitchen", "lights off in hall"]),
        ("rosie in kitchen and living lit", ["rosie in kitchen", "Living lit"]),
    ],
)
def test_a_wish_takes_over_what_it_leaves_out(text: str, wishes: list[str]) -> None:
    assert [wish.text for wish in read_wishes(text, HOUSE)] == wishes


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("kitchn lit", "there is no room 'kitchn'; did you mean Kitchen?"),
        ("scene fim", "there is no scene 'fim'; did you mean Film?"),
        ("kitchen litt", "names no state; did you mean lit?"),
        ("hall on", "would mean everything in it; say 'Hall lit', or 'lights in Hall on'"),
        ("hall lamp not 40 %", "what should be so instead is unclear"),
        ("no film", "what should be so instead is unclear"),
        ("hall lamp toggle", "names no state that lasts"),
        ("hall lamp +10 %", "names no state that lasts"),
        ("hall lamp brighter", "names no state that lasts"),
        ("wait 5s", "names no state that lasts"),
        ("rosie in hall and rosie in kitchen", "rosie cannot be in Hall and in Kitchen at once"),
        ("on", "names no device or no state"),
        (" , and", "the goal is empty"),
        ("", "the goal is empty"),
    ],
)
def test_what_is_not_understood_says_how_to_write_it(text: str, reason: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_wishes(text, HOUSE)
    assert reason in str(caught.value)


def test_a_code_in_a_goal_is_refused_without_being_shown_again() -> None:
    with pytest.raises(UsageError, match="a goal has no code") as caught:
        read_wishes("front lock unlocked with code 1234", HOUSE)
    assert "1234" not in str(caught.value)


@pytest.mark.parametrize("text", ['"a"', "kitchen lit and ", "hall lamp ", "rosie is in ", "heat at 5 "])
def test_twice_as_long_a_goal_takes_no_four_times_the_work_to_read(text: str) -> None:
    """Most take a little more than twice; a reader that tries all pairs of words takes four times."""

    def read(times: int) -> int:
        def work() -> None:
            with suppress(UsageError):
                read_wishes(text * times, HOUSE)

        work()  # caches
        return calls(work)

    assert read(50) < 3.2 * read(25)


OWN_ROOMS = {
    "de": ("Küche", "Flur"),
    "fr": ("cuisine", "salon"),
    "es": ("cocina", "salón"),
    "nl": ("keuken", "gang"),
    "it": ("cucina", "salotto"),
}
OWN_WISHES = {
    "lit": (
        {
            "de": "Küche hell",
            "fr": "cuisine allumée",
            "es": "cocina encendida",
            "nl": "keuken aan",
            "it": "cucina accesa",
        },
        {
            "de": "die Küche ist beleuchtet",
            "fr": "la cuisine est éclairée",
            "es": "la cocina está iluminada",
            "nl": "licht in de keuken",
            "it": "luce in cucina",
        },
        {
            "de": "die Küche soll hell sein",
            "fr": "lumière dans la cuisine",
            "es": "luz en la cocina",
            "nl": "de keuken is verlicht",
            "it": "la cucina deve essere illuminata",
        },
    ),
    "dark": (
        {
            "de": "kein Licht in der Küche",
            "fr": "cuisine éteinte",
            "es": "cocina a oscuras",
            "nl": "keuken donker",
            "it": "cucina al buio",
        },
    ),
    "at 21 °C": (
        {
            "de": "Küche auf 21 Grad",
            "fr": "cuisine à 21 degrés",
            "es": "cocina a 21 grados",
            "nl": "keuken op 21 graden",
            "it": "cucina a 21 gradi",
        },
    ),
}


def own_house(language: str) -> KnownNames:
    rooms = OWN_ROOMS[language]
    return KnownNames(rooms, rooms, ("rosie",), ("Film",))


def without_text(text: str, house: KnownNames) -> list[GoalCondition]:
    wishes = read_wishes(text, house)
    return [wish if isinstance(wish, SceneCondition) else replace(wish, text="") for wish in wishes]


@pytest.mark.parametrize("language", OWN_ROOMS)
def test_a_wish_for_a_room_is_read_in_each_language(language: str) -> None:
    house = own_house(language)
    for state, rows in OWN_WISHES.items():
        meant = without_text(f"{OWN_ROOMS[language][0]} {state}", house)
        assert [without_text(one[language], house) for one in rows] == [meant] * len(rows)


@pytest.mark.parametrize(
    ("language", "text", "english"),
    [
        ("de", "Küchenlampe an", "Küchenlampe on"),
        ("de", "die Haustür ist zu und abgeschlossen", "Haustür closed and locked"),
        ("de", "Küche und Flur hell", "Küche and Flur lit"),
        ("de", "alle Lampen aus", "all lights off"),
        ("de", "das ganze Haus dunkel", "house dark"),
        ("de", "rosie ist in der Küche, Flur dunkel", "rosie in Küche and Flur dark"),
        ("de", "rosie nicht im Flur", "rosie not in Flur"),
        ("de", "schicke rosie zur Ladestation", "rosie at the charging station"),
        ("de", "schalte die Flurlampe ein", "Flurlampe on"),
        ("de", "Szene Film", "scene Film"),
        ("de", "mach das Licht in der Küche an", "Küche lit"),
        ("de", "Küche ist nicht hell", "Küche dark"),
        ("de", "Licht aus", "house dark"),
        ("de", "die Jalousien im Flur zu", "blinds in Flur closed"),
        ("fr", "allume la lumière dans la cuisine", "cuisine lit"),
        ("es", "apaga la luz de la cocina", "cocina dark"),
        ("nl", "doe het licht in de keuken aan", "keuken lit"),
        ("it", "accendi la luce in cucina", "cucina lit"),
        ("fr", "lampe du salon allumée", "lampe du salon on"),
        ("fr", "porte du garage fermée et verrouillée", "porte du garage closed and locked"),
        ("fr", "toutes les lampes éteintes", "all lights off"),
        ("fr", "rosie dans la cuisine et salon éclairé", "rosie in cuisine and salon lit"),
        ("fr", "rosie n'est pas dans le salon", "rosie not in salon"),
        ("fr", "rosie à sa base", "rosie docked"),
        ("fr", "maison dans le noir", "house dark"),
        ("es", "lámpara de noche encendida", "lámpara de noche on"),
        ("es", "puerta principal cerrada con llave", "puerta principal locked"),
        ("es", "rosie está en la cocina y salón iluminado", "rosie in cocina and salón lit"),
        ("es", "todas las luces apagadas", "all lights off"),
        ("es", "envía a rosie a su base", "rosie docked"),
        ("nl", "keukenlamp aan", "keukenlamp on"),
        ("nl", "voordeur dicht en op slot", "voordeur closed and locked"),
        ("nl", "rosie op het laadstation en gang donker", "rosie docked and gang dark"),
        ("nl", "stuur rosie naar keuken", "rosie in keuken"),
        ("it", "lampada del salotto accesa", "lampada del salotto on"),
        ("it", "porta del garage chiusa a chiave", "porta del garage locked"),
        ("it", "rosie in cucina e salotto illuminato", "rosie in cucina and salotto lit"),
        ("it", "tutte le luci spente", "all lights off"),
    ],
)
def test_a_goal_means_the_same_in_each_language(language: str, text: str, english: str) -> None:
    assert without_text(text, own_house(language)) == without_text(english, own_house(language))


@pytest.mark.parametrize(
    ("language", "text", "answer"),
    [
        ("de", "Kücke hell", "es gibt keinen Raum 'Kücke'; meintest du Küche?"),
        (
            "de",
            "die Küche macht im Flur einen Lärm",
            "'die Küche macht im Flur einen Lärm' nennt keinen Zustand",
        ),
        ("fr", "rosie dans la cusine", "il n'y a pas de pièce 'cusine' ; vouliez-vous dire cuisine ?"),
        ("es", "cocima a oscuras", "no hay ninguna habitación 'cocima'"),
        ("it", "schiaccia il pulsante nella cucina", "'schiaccia il pulsante nella cucina' non nomina nessuno stato"),
    ],
)
def test_a_goal_that_is_not_understood_is_answered_in_its_language(language: str, text: str, answer: str) -> None:
    with pytest.raises(UsageError) as caught:
        read_wishes(text, own_house(language))
    assert str(caught.value).startswith(answer)


@pytest.mark.parametrize("at", range(len(COLUMNS)))
def test_the_examples_in_other_languages_are_wishes(at: int) -> None:
    advice = "write it like 'kitchen lit', 'hall dark', 'rosie in kitchen', 'hall lamp on' or 'front door closed'"
    texts = re.findall(r"'(.+?)'", mistake_in(COLUMNS[at], advice))
    assert [text for text in texts if not (to_english(text, "wish") or " in " in text)] == []
