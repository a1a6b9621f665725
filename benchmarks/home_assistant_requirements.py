"""Runs inside Home Assistant's venv: prints the packages that its MQTT integration and what that builds on require."""

from __future__ import annotations

import json
from pathlib import Path

import homeassistant.components

FIRST = ("mqtt", "light", "sensor", "camera")


def requirements(components: Path) -> list[str]:
    wanted: dict[str, None] = {}
    seen: set[str] = set()
    ahead = list(FIRST)
    while ahead:
        name = ahead.pop()
        if name in seen or not (manifest := components / name / "manifest.json").exists():
            continue
        seen.add(name)
        facts = json.loads(manifest.read_text())
        wanted |= dict.fromkeys(facts.get("requirements", ()))
        ahead += facts.get("dependencies", ())
    return list(wanted)


print("\n".join(requirements(Path(homeassistant.components.__path__[0]))))
