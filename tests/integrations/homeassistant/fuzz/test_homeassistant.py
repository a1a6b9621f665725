"""Damaged announcements and messages of Home Assistant's discovery: refused in our words, or understood."""

import json
from pathlib import Path
from typing import Any

from tests.fuzz.conftest import Fuzz, fuzz_convention
from tests.integrations.real_devices import rows_of

from homebot.integrations.homeassistant.formats import HomeAssistantDiscovery, HomeAssistantSettings

COMPONENTS = Path(__file__).parents[1] / "formats" / "components.jsonl"


def components() -> list[dict[str, Any]]:
    """Every component of Home Assistant's configs, beside those of real devices."""
    lines = [json.loads(line) for line in COMPONENTS.read_text().splitlines()]
    steps = [
        [step["read"] for one in line.get("tests", {}).values() for step in one if "read" in step] for line in lines
    ]
    return [
        {"messages": [[f"homeassistant/{line['component']}/x/config", json.dumps(line["config"])]], "says": says}
        for line, says in zip(lines, steps, strict=True)
    ]


def test_damaged_devices_are_refused_or_read(fuzz: Fuzz) -> None:
    rows = [*rows_of("homeassistant"), *components()]
    fuzz_convention(fuzz, "homeassistant", lambda: HomeAssistantDiscovery(HomeAssistantSettings()), rows)
