"""Apps whose classes a program gives directly."""

from pathlib import Path

import anyio
import pytest

from homebot.apps import App, AppSettings
from homebot.config import Config, parse_config
from homebot.errors import ConfigError, HomebotError
from homebot.runtime import Runtime


def config(**tables: object) -> Config:
    return parse_config({"gateways": {}, **tables}, "test")


class Settings(AppSettings):
    word: str = "none"


def teller(told: dict[str, str]) -> type[App[Settings]]:
    """Return a class that no import finds; each app of it tells its name and word."""

    class Teller(App[Settings]):
        async def run(self) -> None:
            told[self.node.name] = self.settings.word
            await anyio.sleep_forever()

    return Teller


async def test_one_class_serves_under_two_names_with_settings_of_its_own() -> None:
    told: dict[str, str] = {}
    kind = teller(told)
    tables = config(apps={"hall": {"word": "hello"}})
    async with Runtime(tables, apps={"hall": kind, "study": kind}, with_door=False) as runtime:
        assert [one.name for one in runtime.app_manager.apps] == ["hall", "study"]
        assert told == {"hall": "hello", "study": "none"}


async def test_its_settings_are_reloaded_and_its_class_stays() -> None:
    told: dict[str, str] = {}
    tables = [config(apps={"hall": {"word": "hello"}})]
    async with Runtime(
        tables[0], apps={"hall": teller(told)}, with_door=False, read_config=lambda: tables[-1]
    ) as runtime:
        runtime.app_manager.trial = 0.05
        tables.append(config(apps={"hall": {"word": "good night"}}))
        await runtime.app_manager.reload("hall")
        assert told == {"hall": "good night"}
        await runtime.app_manager.unload("hall")
        told.clear()
        await runtime.app_manager.load("hall")
        assert told == {"hall": "good night"}
        tables.append(config(apps={"hall": {"wort": "misspelt"}}))
        with pytest.raises(HomebotError, match=r"apps\.hall\.wort: "):
            await runtime.app_manager.reload("hall")


async def test_a_reload_of_the_configuration_asks_for_no_table_of_it() -> None:
    async with Runtime(config(), apps={"hall": teller({})}, with_door=False) as runtime:
        done = await runtime.reload(config)
        assert (done.success, done.message) == (True, "tokens, rights, policies and places were reloaded")


@pytest.mark.parametrize(
    ("tables", "name", "kind", "mistake"),
    [
        (
            {"hall": {"class": "hall:Hall"}},
            "hall",
            teller({}),
            r"apps\.hall\.class: the program gives the class Teller",
        ),
        ({"hall": {"wort": ""}}, "hall", teller({}), r"apps\.hall\.wort: "),
        ({"hall": {"act": "lihgt in"}}, "hall", teller({}), r"apps\.hall\.act: "),
        ({}, "control", teller({}), r"apps\.control: is the name of one of homebot's own nodes"),
        ({}, "hall", Path, r"hall is not an App"),
    ],
)
def test_a_mistake_is_found_before_the_start(
    tables: dict[str, object], name: str, kind: type[App], mistake: str
) -> None:
    with pytest.raises(ConfigError, match=mistake):
        Runtime(config(apps=tables), apps={name: kind})
