"""The texts of routines mean the same in each language, and are shown in it."""

import json
import re
from collections.abc import Callable, Mapping
from itertools import product
from pathlib import Path

import pytest
from tests.call_counts import calls

from homebot.errors import UsageError
from homebot.words import own_language
from homebot.words.conditions import read_condition
from homebot.words.own_language import OWN_LANGUAGES, TextKind, in_language, to_english
from homebot.words.routine_text import rename_scene
from homebot.words.steps import read_step
from homebot.words.triggers import read_trigger

FOLDER = Path(own_language.__file__).parent / "languages"
ROUTINES = json.loads(Path(__file__).with_name("routines_in_languages.json").read_text("utf-8"))
"""Ten routines, as natives of six languages write them."""

NATIVES: Mapping[str, Mapping[TextKind, Mapping[str, str]]] = json.loads(
    Path(__file__).with_name("what_natives_write.json").read_text("utf-8")
)
"""Texts by languages, with their English, that were written by somebody who did not know the forms."""

READERS: Mapping[TextKind, Callable[[str], object]] = {
    "trigger": read_trigger,
    "condition": read_condition,
    "step": read_step,
}

_DEVICES = (
    "Flur open",
    "Flur open for 5m",
    "Flur closed",
    "Flur closed for 2h",
    "Flur on",
    "Flur on for 1m",
    "Flur off",
    "Flur off for 10m",
    "Flur locked",
    "Flur locked for 5m",
    "Flur unlocked",
    "Flur unlocked for 5m",
    "window open",
    "lights in Flur on",
    "no window open",
    "no window open for 10m",
    "motion occupied in Flur",
    "no motion in Flur for 5m",
    "smoke detected in Flur",
    "water detected in Flur",
    "not Flur on",
    "not Flur open",
    "nobody is home for 10m",
    "not everybody is home",
    "power of Flur below 5 W",
    "power of Flur above 5 W for 3m",
    "Flur occupied",
    "Flur occupied for 5m",
    "Flur clear",
    "Flur clear for 5m",
    "Flur smoke detected",
    "Flur water detected",
    "temperature in Flur below 18.5 °C",
    "humidity in Flur above 70 % for 10m",
    "temperature of Flur above 25 °C",
    "number of Grenze below 3 for 10m",
    "temperature of Flur above temperature of Bad",
    "temperature of Flur below number of Grenze",
    "Flur opening",
    "Flur closing for 5m",
    "Flur movement = stopped",
    "Flur cooling",
    "Flur cooling for 5m",
    'name="Flur" heating',
    "Flur thermostat_action = idle for 5m",
    "Flur thermostat_action = fan",
    "Flur thermostat_mode = heat",
    "Flur thermostat_mode = auto for 5m",
    "energy of Flur above 20 kWh",
    "pressure of Flur below 1000 hPa for 5m",
    "soil moisture of Flur below 20 %",
    "soil moisture of Flur below 20 % for 1h",
    "Modus option night",
)
FORMS: Mapping[TextKind, tuple[str, ...]] = {
    "trigger": (
        *_DEVICES,
        "7:00",
        "22:00:30",
        "22:00 on weekdays",
        "7:30 on sat,sun",
        "6:15 on mon-fri",
        "sunset",
        "sunset - 30m",
        "sunrise + 1h30m",
        "every 30m",
        "homebot starts",
        "18:00 on 24 december",
        "9:00 from may to september",
        "7:00 in july",
        "on 1 january",
        "at :15 every hour",
        "message on home/bell",
        "message on home/bell with state.action = ring",
        "at text of Wecker",
        "at text of Wecker - 20m",
        "at value of Wecker",
        "Flur changes",
        "temperature of Flur rises above 25 °C",
        "temperature of Flur falls below 18 °C",
        "temperature in Flur rises above 25 °C",
        "temperature in Flur falls below 18 °C",
        "setpoint of Flur changes",
        "sun elevation below 4°",
        "sun elevation above 10°",
        "sun azimuth below 240.5°",
        "sun azimuth above 180°",
        "nobody is home",
        "everybody has left",
        "somebody arrives",
        "rosie arrives in Bad",
        "rosie leaves Bad",
        "Anna arrives",
        "Anna leaves",
        "Flur press",
        "Flur press single",
        "Flur press double",
        "Flur press triple",
        "Flur press long",
    ),
    "condition": (
        *_DEVICES,
        "no motion in Flur",
        "sun is up",
        "sun is down",
        "after 22:00",
        "before sunrise",
        "between 22:00 and 6:30",
        "between sunset and 23:00",
        "between sunset - 30m and 6:30",
        "after sunrise + 1h",
        "on weekdays",
        "on sat,sun",
        "on 24 december",
        "from may to september",
        "from 20 december to 6 january",
        "in july",
        "last run over 1h ago",
        "not run today",
        "Flur unreachable",
        "Flur unreachable for 1h",
        "run today",
        "text of Wecker over 3d ago",
        "text of Wecker under 3d ago",
        "message on home/bell with ring",
        "started by 22:00",
        "started by Flur open",
        "wait timed out",
        "wait ended by Flur press",
        "in even weeks",
        "in odd weeks",
        "sun elevation below 4°",
        "sun elevation above 10°",
        "sun azimuth below 240.5°",
        "sun azimuth above 180°",
        "chance 1 in 3",
        "Flur open for less than 5m",
        "Flur closed for less than 2h",
        "Flur on for less than 1m",
        "Flur off for less than 10m",
        "nobody in Flur",
        "somebody in Flur",
        "nobody is home",
        "everybody is home",
        "somebody is home",
        "Anna is home",
        "Anna is away",
        "Anna is away for 10m",
        "sun is down or nobody is home",
        "{count of Flur} above 2",
    ),
    "step": (
        "Flur on",
        "Flur off",
        "Flur toggle",
        "Flur brighter",
        "Flur darker",
        "Flur brighter by 20 %",
        "Flur darker by 10 %",
        "Flur on, 20 %",
        "Flur 40 %",
        "Flur 21.5 °C",
        "Flur heating",
        "Flur heating, 21.5 °C",
        "Flur cooling",
        "Flur cooling, 24 °C",
        "Flur open",
        "Flur close",
        "Flur lock",
        "Flur unlock",
        "lights off",
        "lights in Flur off",
        "wait 90s",
        "notify {now}",
        "wait until Flur closed, at most 30m",
        "wait until no motion in Flur for 2m, at most 1h",
        "notify {temperature of Flur}, that is cold: 7:00",
        "scene Film",
        "scene Film, over 5s",
        "notify {name of it} in {room of it}, {time}, {before}",
        "it on",
        "Modus option night",
        "Flur floor 2",
        "rosie go to Bad",
        "rosie go to dock",
        "Flur cleaning",
        "Flur heat",
        "Flur cool",
        "wait 5m to 40m",
        "Flur {level of Bad + 10} %",
        "Flur on, {min(sun elevation * 2, 100)} %, over 5s",
        "Flur on, over 5s",
        "Flur off, over 5s",
        "Flur 20 %, over 1m30s",
        "Flur position {100 - sun elevation} %",
        "Flur color_temperature {number of Grenze} K",
        "Flur fan_speed {default(temperature of Bad * 4, 0)} %",
        "Flur volume 25 %",
        "Flur tilt 50 %",
        "Flur number {illuminance of Bad}",
        "Flur heating_setpoint {number of Ziel - 2}",
        "wait {number of Pause}m",
        "wait until it closed, at most 5m",
        "wait until Flur closed, at most 5m, then stop",
        "wait until Flur closed and until no motion in Flur for 2m, at most 5m",
        "wait until Flur closed and until Bad on, at most 5m, then stop",
        "notify {names of Flur}, {names with battery of window}",
        "wait for Flur press or 23:00, at most 1h",
        "wait for Flur open, at most 1h, then stop",
        "routine Film on",
        "routine Film off",
        "run routine Film",
        "undo",
        "stop",
    ),
}


def every_form() -> list[tuple[TextKind, str]]:
    return [(kind, text) for kind, texts in FORMS.items() for text in texts]


@pytest.mark.parametrize("language", OWN_LANGUAGES)
@pytest.mark.parametrize(("kind", "text"), every_form())
def test_each_form_is_shown_in_each_language_and_read_again(kind: TextKind, text: str, language: str) -> None:
    shown = " or ".join(in_language(part, kind, language) for part in text.split(" or "))
    assert shown != text
    if " or " not in text:
        assert in_language(shown, kind, language) == shown
        assert READERS[kind](shown) == READERS[kind](text)


@pytest.mark.parametrize("language", OWN_LANGUAGES)
def test_conditions_are_joined_by_the_word_of_the_language(language: str) -> None:
    words = {"de": "oder", "fr": "ou", "it": "o", "es": "o", "nl": "of"}
    own = f" {words[language]} ".join(
        in_language(one, "condition", language) for one in ("sun is down", "nobody is home")
    )
    assert read_condition(own) == read_condition("sun is down or nobody is home")


@pytest.mark.parametrize(("language", "number"), list(product(OWN_LANGUAGES, range(len(ROUTINES)))))
def test_ten_routines_mean_the_same_in_each_language(language: str, number: int) -> None:
    english, own = ROUTINES[number]["en"], ROUTINES[number][language]
    for kind, read in READERS.items():
        assert [read(text) for text in own[kind]] == [read(text) for text in english[kind]]


@pytest.mark.parametrize("language", OWN_LANGUAGES)
@pytest.mark.parametrize("kind", READERS)
def test_what_natives_write_is_read(language: str, kind: TextKind) -> None:
    texts = NATIVES[language][kind]
    assert {text: to_english(text, kind) for text in texts} == texts


def test_no_english_text_is_taken_for_another_language() -> None:
    assert [text for kind, text in every_form() if to_english(text, kind) not in {None, text}] == []


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ("wenn die Haustür 5 Minuten ofen ist", "offne|offen"),
        ("quand la porte fait des bruits dans la cuisine", "n'est pas un déclencheur"),
        ("quando la porta fa rumore nella cucina", "non è un evento"),
        ("cuando la puerta hace ruido en la cocina", "no es un desencadenante"),
        ("als de deur lawaai maakt in de keuken", "begrijp ik niet"),
    ],
)
def test_a_mistake_is_answered_in_its_language(text: str, hint: str) -> None:
    with pytest.raises(UsageError, match=hint):
        read_trigger(text)


@pytest.mark.parametrize("text", ["Alle Lampen on", "'Die Drei' on", "Lampe im Flur on"])
def test_names_in_english_texts_stay(text: str) -> None:
    assert read_step(text) == read_step(text.replace("  ", " "))
    assert to_english(text, "step") is None


def test_a_name_in_quotes_keeps_its_article() -> None:
    assert read_step("schalte 'Die Drei' ein") == read_step("'Die Drei' on")


@pytest.mark.parametrize("piece", ["wenn ", "die Lampe ist an ", "l'", "oder ", "ist seit 1 ", "21,5 ", "a la in di "])
@pytest.mark.parametrize("kind", FORMS)
def test_a_hostile_text_in_another_language_costs_little(kind: TextKind, piece: str) -> None:
    for length in (300, 20_000):
        text = piece * (length // len(piece))
        assert calls(lambda text=text: to_english(text, kind)) < 500 * 300  # type: ignore[misc]


@pytest.mark.parametrize("language", OWN_LANGUAGES)
def test_each_language_has_each_form_with_its_slots(language: str) -> None:
    tables = {code: json.loads((FOLDER / f"{code}.json").read_text("utf-8")) for code in ("de", language)}
    for kind in ("state", *READERS):
        assert list(tables[language][kind]) == list(tables["de"][kind])
        for english, row in tables[language][kind].items():
            for form in row.split(" / "):
                assert sorted(re.findall(r"{.}", form)) == sorted(re.findall(r"{.}", english)), form


@pytest.mark.parametrize(
    ("step", "renamed"),
    [
        ("Szene Film", "Szene Kino"),
        ("aktiviere die Szene 'Film'", "aktiviere die Szene Kino"),
        ("lance la scène Film, sur 5 secondes", "lance la scène Kino, sur 5 secondes"),
        ("attiva scena film", "attiva scena Kino"),
        ("escena Film", "escena Kino"),
        ("activeer de scène Film", "activeer de scène Kino"),
        ("scene Film", "scene Kino"),
        ("melde Szene Film", "melde Szene Film"),
        ("Szene Filmabend", "Szene Filmabend"),
    ],
)
def test_a_renamed_scene_is_renamed_in_each_language(step: str, renamed: str) -> None:
    assert rename_scene(f'do = ["{step}", "wait 5m"]', "Film", "Kino") == f'do = ["{renamed}", "wait 5m"]'


@pytest.mark.parametrize(
    ("language", "shown"),
    [
        ("de", "warte bis Flur seit 2 Minuten keine Bewegung erkennt, höchstens 4 Stunden"),
        ("nl", "wacht tot Flur al 2 minuten geen beweging ziet, hoogstens 4 uur"),
        ("it", "aspetta che Flur non rilevi movimento da 2 minuti, al massimo 4 ore"),
        ("es", "espera hasta que Flur no detecte movimiento desde hace 2 minutos, como máximo 4 horas"),
    ],
)
def test_what_is_awaited_has_its_verb_as_the_language_wants_it(language: str, shown: str) -> None:
    assert in_language("wait until Flur clear for 2m, at most 4h", "step", language) == shown
