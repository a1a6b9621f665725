"""The picture of the packages in CONTRIBUTING.md, drawn from the imports.

To draw it anew, run with ``HOMEBOT_WRITE_GOLDEN=1``.
"""

import os
from collections.abc import Mapping
from graphlib import TopologicalSorter
from html import escape
from pathlib import Path

import pytest
from tests.import_graph import import_graph

PICTURE = Path(__file__).parents[1] / "docs" / "packages.svg"
WIDTH, BOX, HEIGHT, GAP = 900, 96, 30, 74

HEAD = """<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}">
<style>
  rect {{ fill: #eef; stroke: #447 }}
  text {{ font: 14px sans-serif; text-anchor: middle }}
  .arrows {{ fill: none; stroke: #888 }}
</style>
<marker id="head" orient="auto" markerWidth="8" markerHeight="8" refX="7" refY="3"><path d="M0 0L7 3L0 6z"/></marker>
<g class="arrows">"""

Imports = Mapping[str, set[str]]


@pytest.fixture(scope="module")
def imports() -> Imports:
    """For each package of homebot those that it imports."""
    graph = import_graph()
    names = {module.split(".")[1] for module in graph if module.count(".") > 1}
    names.remove("testing")  # may import anything
    found: dict[str, set[str]] = {name: set() for name in names}
    for importer, all_imported in graph.items():
        for imported in all_imported:
            ends = [module.partition(".")[2].partition(".")[0] for module in (importer, imported)]
            if ends[0] in names and ends[1] in names and ends[0] != ends[1]:
                found[ends[0]].add(ends[1])
    return found


def below(name: str, imports: Imports) -> set[str]:
    """All that *name* needs."""
    return imports[name].union(*(below(one, imports) for one in imports[name]))


def rows(imports: Imports) -> list[list[str]]:
    """The packages from top to bottom: each one as low as its imports allow."""
    level: dict[str, int] = {}
    for name in TopologicalSorter(imports).static_order():
        level[name] = 1 + max((level[one] for one in imports[name]), default=-1)
    return [sorted(one for one in level if level[one] == height) for height in range(max(level.values()), -1, -1)]


def drawn(imports: Imports) -> str:
    """The picture as SVG. An arrow that follows from two others is left out."""
    place = {
        name: (WIDTH * (column + 1) // (len(row) + 1), GAP * line + HEIGHT)
        for line, row in enumerate(rows(imports))
        for column, name in enumerate(row)
    }
    arrows = []
    for name in sorted(imports):
        indirect = set().union(*(below(one, imports) for one in imports[name]))
        for one in sorted(imports[name] - indirect):
            (x, y), (to_x, to_y) = place[name], place[one]
            arrows.append(f'<path d="M{x} {y + HEIGHT // 2}L{to_x} {to_y - HEIGHT // 2}" marker-end="url(#head)"/>')
    boxes = [
        f'<rect x="{x - BOX // 2}" y="{y - HEIGHT // 2}" width="{BOX}" height="{HEIGHT}" rx="4"/>'
        f'<text x="{x}" y="{y + 5}">{escape(name)}</text>'
        for name, (x, y) in sorted(place.items())
    ]
    head = HEAD.format(width=WIDTH, height=GAP * len(rows(imports)))
    return "\n".join([head, *arrows, "</g>", *boxes, "</svg>\n"])


@pytest.mark.rooms("alerts", "bags", "goals", "history", "homeassistant", "scenes", "things")
def test_the_picture_shows_the_imports_in_one_direction(imports: Imports) -> None:
    picture = drawn(imports)
    if os.environ.get("HOMEBOT_WRITE_GOLDEN"):
        PICTURE.write_text(picture)

    assert PICTURE.read_text() == picture
