"""The code of the core names no integration, not even in a text; docstrings may tell of one as an example."""

import ast
import re
from collections.abc import Iterator
from typing import Final

import pytest
from tests.source_trees import SOURCE, source_trees

INTEGRATIONS: Final = {one.parent.name for one in (SOURCE / "integrations").glob("*/__init__.py")}
WORDS: Final = INTEGRATIONS & {"hue", "matter", "things"}
"""Names that are words as well, which count as a text of their own."""

_SPELLED: Final = {"homeassistant": "home[ _-]?assistant", "zigbee2mqtt": "zigbee[ _-]?2[ _-]?mqtt"}
_NAMED: Final = re.compile(
    f"(?<![a-z])(?:{'|'.join(_SPELLED.get(one, one.replace('_', '[ _-]?')) for one in sorted(INTEGRATIONS - WORDS))})",
    re.IGNORECASE,
)
_WORD: Final = re.compile(rf"(?:gateways\.|_)?(?:{'|'.join(sorted(WORDS))})(?:\._tcp(?:\.local\.)?)?")
EXCEPTIONS: Final = {
    "cli/commands/owner.py": "its help shows a device to pair, and the reasons of a merged one",
    "cli/commands/run.py": "the house of the thesis is a word of the command line",
    "conventions/bluetooth/bthome_objects.py": "a public registry, which two integrations read",
    "devices/identity.py": "a bridge tells by its identifier alone that it takes other names of a device",
    "discovery/merging/identity.py": "words that many devices have in place of an identifier",
    "house/__init__.py": "the house of the thesis",
    "house/simulated_device.py": "the family that files of houses have where they state none",
    "testing/house_marks.py": "the house of the thesis",
}


def is_called_after_one(path: str) -> bool:
    """Return whether a module is of a feature for other programs of an ecosystem, which nothing else names either."""
    folder, _, name = path.partition("/")
    return folder == "features" and _NAMED.match(name) is not None


def named_in(tree: ast.Module) -> Iterator[str]:
    """Yield each text that is no docstring, and each name, that names an integration."""
    docstrings = {id(one.value) for one in ast.walk(tree) if isinstance(one, ast.Expr)}
    for node in ast.walk(tree):
        names = [getattr(node, field, None) for field in ("id", "attr", "arg", "name", "module")]
        yield from (name for name in names if isinstance(name, str) and _NAMED.search(name))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in docstrings:
            yield from [node.value] if _NAMED.search(node.value) or _WORD.fullmatch(node.value) else ()


@pytest.mark.rooms("bthome", "hue", "shelly", "tasmota", "thesis", "zigbee2mqtt")
def test_the_core_names_no_integration() -> None:
    tree = ast.parse("def read_homekit(): return {'gateways.hue': knowledge['hue in degrees']}")
    assert sorted(named_in(tree)) == ["gateways.hue", "read_homekit"]
    core = {
        path: tree
        for path, tree in source_trees().items()
        if not path.startswith("integrations/") and not is_called_after_one(path)
    }
    found = {path: names for path, tree in core.items() if (names := list(named_in(tree)))}
    assert {path: names for path, names in found.items() if path not in EXCEPTIONS} == {}
    assert found.keys() == EXCEPTIONS.keys(), "an exception is not needed any more"
