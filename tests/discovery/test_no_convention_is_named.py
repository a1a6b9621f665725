"""Discovery knows no convention and no protocol: what it needs of them stands in the sightings."""

import ast
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path

import homebot.discovery

NAMES = {
    found.name for group in ("homebot.mqtt_conventions", "homebot.gateways") for found in entry_points(group=group)
}
FOLDER = Path(homebot.discovery.__file__).parent


def named_in(source: str) -> Iterator[str]:
    """Yield each name of a convention or gateway that is compared with, or looked up."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Constant) and node.value in NAMES:
            yield str(node.value)


def test_no_file_of_discovery_names_a_convention_or_a_gateway() -> None:
    assert list(named_in("x = gateway in {'mqtt', 'other'}")) == ["mqtt"]
    found = {file.name: list(named_in(file.read_text())) for file in FOLDER.rglob("*.py")}
    assert {name: names for name, names in found.items() if names} == {}
