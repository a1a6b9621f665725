"""The guide docs/testing.md: everything that it shows works as it stands there."""

import re
import shutil
from pathlib import Path

import pytest

pytest_plugins = ["pytester"]

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples" / "02_window_light"

SHOWN = re.findall(
    r"(?:<!-- (.*?) -->\n)?```(python|toml)\n(.*?)```", (ROOT / "docs" / "testing.md").read_text("utf-8"), re.DOTALL
)
TESTS = [text for what, _, text in SHOWN if what.startswith("test")]
PROGRAMS = [text for what, _, text in SHOWN if what == "program"]
FILES = {what.removeprefix("file: "): text for what, _, text in SHOWN if what.startswith("file: ")}


def test_nothing_is_shown_that_is_not_run() -> None:
    assert len(TESTS) + len(PROGRAMS) + len(FILES) == len(SHOWN)
    assert len(TESTS) > 5


@pytest.mark.rooms("thesis")
def test_the_tests_pass_without_any_configuration(pytester: pytest.Pytester) -> None:
    shutil.copy(EXAMPLE / "window_light.py", pytester.path)
    for name, text in FILES.items():
        (pytester.path / name).write_text(text)
    pytester.makepyfile(**{f"test_guide_{number}": text for number, text in enumerate(TESTS)})
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", "--strict-markers")
    result.assert_outcomes(passed=len(TESTS))


def test_the_first_is_that_of_the_example() -> None:
    assert TESTS[0] == (EXAMPLE / "test_window_light.py").read_text()


@pytest.mark.parametrize("program", PROGRAMS)
def test_the_programs_run(program: str, capsys: pytest.CaptureFixture[str]) -> None:
    exec(program, {})  # noqa: S102 - our own guide
    assert "mqtt" in capsys.readouterr().out
