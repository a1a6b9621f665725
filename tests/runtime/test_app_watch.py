"""Apps that are reloaded when their files change."""

from pathlib import Path

import anyio
import pytest
from structlog.testing import capture_logs
from tests.patience import until

from homebot.cli.main import main
from homebot.config import parse_config
from homebot.runtime import Runtime
from homebot.runtime.app_manager import NOT_RELOADED, RELOADED

APP = """
from anyio import sleep_forever
from homebot import App

class {kind}(App):
    word = "{word}"
    async def run(self):
        await sleep_forever()
"""


@pytest.mark.newest("watchfiles")
async def test_an_app_is_reloaded_when_its_file_changes_and_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hall, attic = tmp_path / "watched_hall.py", tmp_path / "watched_attic.py"
    hall.write_text(APP.format(kind="Hall", word="first"))
    attic.write_text(APP.format(kind="Attic", word="first"))
    monkeypatch.syspath_prepend(str(tmp_path))
    apps = {"hall": {"class": "watched_hall:Hall"}, "attic": {"class": "watched_attic:Attic"}}
    config = parse_config({"apps": apps, "door": {"port": 0}}, "test")
    with capture_logs() as lines:
        async with Runtime(config, with_door=False, watches_apps=True) as runtime:
            runtime.app_manager.trial = 0.05

            def reloads(event: str = RELOADED) -> list[object]:
                return [one["app"] for one in lines if one["event"] == event]

            def word() -> object:
                return getattr(runtime.app_host.running["hall"], "word", None)

            while "attic" not in reloads():  # until it watches
                attic.write_text(APP.format(kind="Attic", word="saved"))
                await anyio.sleep(0.2)
            hall.write_text(APP.format(kind="Hall", word="saved"))
            await until(lambda: "hall" in reloads())
            assert word() == "saved"

            (tmp_path / "notes.py").write_text("no app")
            new = tmp_path / "watched_hall.py~"
            new.write_text(APP.format(kind="Hall", word="moved"))
            new.replace(hall)
            await until(lambda: reloads().count("hall") == 2)
            assert word() == "moved"

            hall.write_text("class Hall(App:")
            await until(lambda: reloads(NOT_RELOADED))
            assert word() == "moved"

            hall.write_text(APP.format(kind="Hall", word="mended"))
            await until(lambda: reloads().count("hall") == 3)
            assert word() == "mended"


async def test_a_module_of_an_app_that_is_a_package_is_watched(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder = tmp_path / "watched_house"
    (folder / "rooms").mkdir(parents=True)
    (folder / "rooms" / "__init__.py").write_text('WORD = "first"')
    (folder / "__init__.py").write_text("from watched_house.rooms import WORD\n" + APP.format(kind="Hall", word="x"))
    monkeypatch.syspath_prepend(str(tmp_path))
    config = parse_config({"apps": {"hall": {"class": "watched_house:Hall"}}, "door": {"port": 0}}, "test")
    with capture_logs() as lines:
        async with Runtime(config, with_door=False, watches_apps=True) as runtime:
            runtime.app_manager.trial = 0.05
            while not any(one["event"] == RELOADED for one in lines):
                (folder / "rooms" / "__init__.py").write_text('WORD = "second"')
                await anyio.sleep(0.2)


def test_without_the_extra_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    assert main(["run", "--reload", "--for", "1"]) == 1
    assert capsys.readouterr().err == (
        'homebot: --reload needs watchfiles; install it with: pip install "homebot[watchfiles]"\n'
    )
