"""Write the programs of the guides, and the apps of the examples, into a folder, for a checker of types."""

import re
import sys
from collections.abc import Iterator
from contextlib import chdir
from pathlib import Path

from tests.guide import guide

from homebot.cli.main import main

_PROGRAM = re.compile(r"<!-- file: (?P<name>[\w.]+\.py) -->\n```python\n(?P<text>.*?)```", re.DOTALL)
_CHANGE = re.compile(r"```python\n(?P<imports>from.*?)\n+(?P<app>class.*?)```", re.DOTALL)
_GUIDES = ("bus", "coming-from", "embed")
_EXAMPLES = Path(__file__).parents[2] / "examples"
_UNTYPED = {"08_robot", "10_ros2_robot", "12_thesis"}
"""Examples with libraries of others that have no types."""


def change_first_app(app: Path) -> None:
    """Change the app that ``homebot new`` wrote as the guide says."""
    (change,) = _CHANGE.finditer(guide("first-app"))
    head = app.read_text("utf-8").partition("class HallLight")[0].partition("class ShiningHall")[0]
    app.write_text(f"{change['imports']}\n{head}{change['app']}", "utf-8")


def _programs() -> Iterator[tuple[str, str]]:
    for name in _GUIDES:
        for program in _PROGRAM.finditer(guide(name)):
            yield f"{name}/{program['name']}", program["text"]
    for example in _EXAMPLES.glob("*/*.py"):
        if example.parent.name not in _UNTYPED and not example.name.startswith("test_"):
            yield f"{example.parent.name}/{example.name}", example.read_text("utf-8")


if __name__ == "__main__":
    folder = Path(sys.argv[1])
    for place, text in _programs():
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).write_text(text, "utf-8")
    with chdir(folder):
        main(["new", "hall_light"])
    change_first_app(folder / "hall_light" / "hall_light.py")
