"""A mistake in a routine is told in the language of its text, or else of the house."""

from pathlib import Path

import pytest
from tests.features.routines.test_kept_routines import Owner, homebot

from homebot.cli.commands.run import config_errors
from homebot.cli.main import main
from homebot.config import load_tables, parse_settings
from homebot.errors import ConfigError
from homebot.features.routines.settings import RoutineSettings
from homebot.words.mistakes import mistake_in

ROUTINE = '[[routines]]\nname = "Abend"\nwhen = ["22:00"]\ndo = [{}]\n'
ANSWERS = {
    "de": "'hall lamp onn' ist kein Schritt: es endet nicht mit einem Befehl; meintest du on?",
    "fr": "'hall lamp onn' n'est pas une étape : elle ne finit pas par une commande ; vouliez-vous dire on ?",
    "es": "'hall lamp onn' no es un paso: no termina en una orden; ¿querías decir on?",
    "nl": "'hall lamp onn' is geen stap: het eindigt niet met een opdracht; bedoelde je on?",
    "it": "'hall lamp onn' non è un'azione: non finisce con un comando; volevi dire on?",
    "en": "'hall lamp onn' is no step: it ends with no command; did you mean on?",
}
HINTS = {
    "schalte die Flurlampe ein": "kein Gerät passt zu 'Flurlampe'; `homebot find` zeigt, was passt",
    "allume la lampe du couloir": "aucun appareil n'a le mot 'lampe' ; vouliez-vous dire lamp ou lamps ?",
    "enciende la lámpara": "ningún dispositivo encaja con 'lámpara'; `homebot find` muestra lo que sirve",
    "zet de ganglamp aan": "geen apparaat past bij 'ganglamp'; `homebot find` toont wat past",
    "accendi la lampada": "nessun dispositivo corrisponde a 'lampada'; `homebot find` mostra ciò che va bene",
}


@pytest.mark.virtual_time
@pytest.mark.parametrize("language", ANSWERS)
async def test_an_english_text_is_answered_as_the_house_speaks(language: str, tmp_path: Path) -> None:
    async with homebot(tmp_path, home={"language": language}) as owner:
        answer = await owner.change("new", text=ROUTINE.format('"hall lamp onn"'))
    assert answer.message == f"the text:4: routines.abend.do.0: {ANSWERS[language]}"  # its place stays, for the page


@pytest.mark.virtual_time
@pytest.mark.parametrize("step", HINTS)
async def test_a_hint_is_told_in_the_language_of_the_step(step: str, tmp_path: Path) -> None:
    async with homebot(tmp_path) as owner:
        answer = await owner.change("new", text=ROUTINE.format(f"'{step}'"))
        assert answer.message.splitlines() == ["added Abend", f"Abend: '{step}': {HINTS[step]}"]
        assert await hints(owner) == (f"'{step}': {HINTS[step]}",)


async def hints(owner: Owner) -> tuple[str, ...]:
    return (await owner.routines(check=True))["Abend"].hints


@pytest.mark.parametrize(
    ("keys", "reason"),
    [
        ({"max": 0}, "muss mindestens 1 sein; hier 0"),
        ({"max": 1000}, "darf höchstens 100 sein; hier 1000"),
        ({"mode": "oft"}, "muss 'single', 'restart', 'queued' oder 'parallel' sein; hier 'oft'"),
        ({"enabled": "ja"}, "muss true oder false sein, ohne Anführungszeichen; hier 'ja'"),
        ({"max": "2"}, "muss eine ganze Zahl sein, ohne Anführungszeichen; hier '2'"),
        ({"when": "22:00"}, "muss eine Liste in [ ] sein; hier '22:00'"),
        ({"when": []}, "ist leer; mindestens 1 Eintrag gehört hinein; hier []"),
        ({"when": [22]}, "muss ein Text in Anführungszeichen sein; hier 22"),
        ({"when": [""]}, "muss mindestens 1 Zeichen haben; hier ''"),
        ({"mod": "single"}, "unbekannter Schlüssel; meintest du mode?"),
    ],
)
def test_a_wrong_key_is_told_too(keys: dict[str, object], reason: str) -> None:
    with pytest.raises(ConfigError) as caught:
        parse_settings(RoutineSettings, {"name": "Abend", "when": ["22:00"], "do": ["stop"], **keys}, "", "")
    assert mistake_in("de", caught.value.reason) == reason


def test_too_many_lines_and_characters_are_told_too() -> None:
    table = {"name": "N" * 200, "when": ["22:00"] * 200, "do": ["stop"]}
    with pytest.raises(ConfigError) as caught:
        parse_settings(RoutineSettings, table, "", "")
    reasons = [mistake_in("de", one.reason) for one in (caught.value, *caught.value.others)]
    assert [one.partition("; hier")[0] for one in reasons] == [
        "darf höchstens 100 Zeichen haben",
        "darf höchstens 50 Einträge haben, nicht 200",
    ]


@pytest.mark.virtual_time
async def test_a_mistake_in_the_form_of_a_text_is_told_with_its_line(tmp_path: Path) -> None:
    async with homebot(tmp_path, home={"language": "it"}) as owner:
        answer = await owner.change("new", text="[[routines]]\nname = Sera\n")
    assert answer.message == (
        "il testo non è TOML valido: questo valore non è valido (riga 2, colonna 8); un testo sta tra virgolette, "
        "true e false in minuscolo"
    )


def test_a_file_is_checked_in_the_language_of_its_house(tmp_path: Path) -> None:
    file = tmp_path / "homebot.toml"
    file.write_text('[home]\nlanguage = "nl"\n' + ROUTINE.format('"hall lamp onn"'))
    file.chmod(0o600)
    errors = config_errors(load_tables(file), file)
    assert [error.reason for error in errors] == [ANSWERS["nl"]]


def test_the_command_line_answers_in_the_language_of_the_house(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Even of a configuration that is no TOML."""
    monkeypatch.chdir(tmp_path)
    Path("homebot.toml").write_text('[home]\nlanguage = "de"\n[door\n')
    assert main(["config", "check"]) == 1
    assert capsys.readouterr().err == (
        "homebot: homebot.toml ist kein gültiges TOML: am Ende des Namens einer Tabelle fehlt ] (Zeile 3, Spalte 6)\n"
    )
    Path("homebot.toml").write_text('[home]\nlanguage = "fr"\n')
    assert main(["routine", "try", "soir.toml"]) == 1
    assert capsys.readouterr().err == "homebot: soir.toml n'existe pas\n"
