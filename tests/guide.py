"""The guides in ``docs``, and what they show."""

import re
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"


def guide(name: str) -> str:
    """Return the text of ``docs/NAME.md``."""
    return (DOCS / f"{name}.md").read_text("utf-8")


def commands_in(text: str) -> list[str]:
    """Return the commands that a reader types, without the remarks behind them."""
    return [re.sub(r" +#.*", "", command) for command in re.findall(r"^\$ (.*)$", text, re.MULTILINE)]


def blocks_in(text: str, language: str) -> list[str]:
    """Return the blocks of *text* in a language."""
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def section_in(text: str, name: str) -> str:
    """Return the section of *text* below that heading."""
    return text[text.index(f"## {name}") :].partition("\n## ")[0]
