"""Routines that are exported as apps, with their tests."""

import subprocess
import sys
from pathlib import Path

import pytest
from tests.features.routines.week import ROUTINES

from homebot.features.routines.export import app_text, class_name, module_name, pytest_text
from homebot.features.routines.text import read_routines, read_settings

pytestmark = pytest.mark.slow

HOSTILE = r"""
name = 'Say "hi" \ '
when = ["22:00"]
do = ['notify \n "" %s {time}', { if = ["after 9:00"], do = ["wait 1m"], else = [
    "wait 2m", { if = ["on sat"], do = ["wait 3m"] }
] }]
"""


def exported(text: str, folder: Path) -> Path:
    """Write the app and the test of a routine, and return the file of the app."""
    (routine,) = read_routines(text, "test")
    settings = read_settings(text, "test")
    path = folder / f"{routine.app}.py"
    path.write_text(app_text(settings))
    path.with_name(f"test_{path.name}").write_text(pytest_text(settings, routine.app))
    return path


def test_an_app_reads_like_its_routine(tmp_path: Path) -> None:
    text = """
        name = "Coming home"
        when = ["front door open"]
        if = ["sun is down"]
        do = [{ if = ["nobody in hall", "hall lamp off"], do = ["hall lamp on"], else = [
            { if = ["nobody in study"], do = ["wait 1m"], else = ["wait 5m"] }
        ] }, "undo"]
        mode = "restart"
    """
    assert exported(text, tmp_path).read_text() == (
        '"""Coming home: a routine as an app, which you may change."""\n\n'
        "from homebot.apps import RoutineApp\n\n\n"
        "class ComingHome(RoutineApp):\n"
        "    when = ('front door open',)\n"
        "    conditions = ('sun is down',)\n"
        '    mode = "restart"\n\n'
        "    async def perform(self) -> None:\n"
        "        if await self.holds('nobody in hall', 'hall lamp off'):\n"
        "            await self.step('hall lamp on')\n"
        "        elif await self.holds('nobody in study'):\n"
        "            await self.step('wait 1m')\n"
        "        else:\n"
        "            await self.step('wait 5m')\n"
        "        await self.step('undo')\n"
    )


def test_the_tests_pass_as_they_are_written_also_with_hostile_texts(tmp_path: Path) -> None:
    texts = [f"[[routines]]\n{one}" for one in ROUTINES.read_text("utf-8").split("[[routines]]\n")[1:]]
    for text in (*texts, HOSTILE):
        exported(text, tmp_path)
    assert class_name(read_settings(HOSTILE, "test")) == "SayHi"
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(tmp_path)],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=tmp_path,
    )
    assert done.returncode == 0, done.stdout
    assert "11 passed" in done.stdout


@pytest.mark.parametrize(("app", "module"), [("hall", "hall"), ("def", "routine_def"), ("asyncio", "routine_asyncio")])
def test_the_module_hides_no_other_and_can_be_imported(app: str, module: str) -> None:
    assert module_name(app) == module
