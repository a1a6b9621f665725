"""Discovery knows no convention and no protocol: what it needs of them stands in the sightings."""

import ast
from collections.abc import Iterator
from pathlib import Path

import homebot.discovery
from homebot.plugins import plugin_names

NAMES = {*plugin_names("homebot.mqtt_conventions"), *plugin_names("homebot.gateways")}
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
