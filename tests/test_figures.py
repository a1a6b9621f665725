"""The figures of documents: those that benchmarks wrote, and on a page that tells of another, those of that page."""

import json
import re
from collections.abc import Iterator
from typing import NamedTuple

import pytest
from tests.guide import DOCS, blocks_in, guide, section_in

MEASURED: dict[str, list[str]] = json.loads((DOCS.parent / "benchmarks/figures.json").read_text("utf-8"))
SECTIONS = {
    "Discovery": "discovery",
    "Commands to devices with faults": "outcomes",
    "Lamps left on": "left_on",
}
"""Sections of docs/benchmarks.md with the figures of one benchmark."""

UNITS = {
    "M/s": ("a second", 1e6),
    "k/s": ("a second", 1e3),
    "messages/s": ("a second", 1.0),
    "µs": ("s", 1e-6),
    "ms": ("s", 1e-3),
    "s": ("s", 1.0),
    "min": ("s", 60.0),
    "%": ("%", 1.0),
    "x": ("times", 1.0),
    "times": ("times", 1.0),
    "kB": ("B", 1e3),
    "MB": ("B", 1e6),
}
_FIGURE = re.compile(rf"(?<![\w.,])(\d[\d,]*)(\.\d+)? ?({'|'.join(UNITS)})(?![\w/])")
_OF = re.compile(r"(?<![\w.,])\d[\d,]* of \d[\d,]*")
_LINK = re.compile(r"\]\(([\w-]+)\.md(#[\w-]+)?\)")


class Figure(NamedTuple):
    text: str
    value: float
    step: float
    """The value of its last digit."""

    unit: str

    def is_in(self, others: "list[Figure]") -> bool:
        """Whether one of *others* is the same, perhaps with more digits."""
        near = (
            abs(self.value - one.value) <= 0.501 * max(self.step, one.step) for one in others if one.unit == self.unit
        )
        return any(near)


def figures_in(text: str) -> Iterator[Figure]:
    for whole, rest, unit in _FIGURE.findall(text):
        number, (kind, factor) = whole.replace(",", ""), UNITS[unit]
        step = 10.0 ** (1 - len(rest)) if rest else 1.0
        yield Figure(f"{whole}{rest} {unit}", float(number + rest) * factor, step * factor, kind)


def rows_in(section: str) -> Iterator[str]:
    for line in section.splitlines():
        if line.startswith("| ") and not line.startswith("| ---"):
            yield line.strip("| ")


def rows_of_benchmarks() -> Iterator[tuple[str, str]]:
    page, name = guide("benchmarks"), ""
    for row in [*rows_in(section_in(page, "Speed"))][1:]:
        named = re.match(r"`([\w ]+?)[` ]", row)
        if named:
            name = "command_line" if named[1].startswith("devices") else named[1]
        yield name, row
    for section, benchmark in SECTIONS.items():
        yield from ((benchmark, row) for row in [*rows_in(section_in(page, section))][1:])
    yield from (("identify", row) for row in [*rows_in(section_in(guide("identify"), "What it was measured with"))][1:])


@pytest.mark.parametrize(("benchmark", "row"), [*rows_of_benchmarks()])
def test_a_figure_of_a_benchmark_is_one_that_it_wrote(benchmark: str, row: str) -> None:
    measured = [figure for line in MEASURED[benchmark] for figure in figures_in(line)]
    assert [figure.text for figure in figures_in(row) if not figure.is_in(measured)] == []


def test_the_packages_in_the_figure_of_the_thesis_s_page_exist() -> None:
    names = re.findall(r"\b([a-z/]+/|[a-z/]+\.py)(?=\W)", blocks_in(guide("thesis"), "text")[0])
    assert len(names) >= 8
    assert [name for name in names if not (DOCS.parent / "src/homebot" / name).exists()] == []


def test_the_figures_of_the_thesis_s_page_are_those_of_the_pages_that_it_links() -> None:
    strange = []
    for row in guide("thesis").splitlines():
        linked = [guide(name) for name, _ in _LINK.findall(row) if (DOCS / f"{name}.md").is_file()]
        known = [figure for page in linked for figure in figures_in(page)]
        if row.startswith("|") and linked:
            strange += [figure.text for figure in figures_in(row) if not figure.is_in(known)]
            strange += [text for text in _OF.findall(row) if not any(text in page for page in linked)]
    assert strange == []
