"""Checks configs against the schemas of an installed Home Assistant, under its Python; see test_published_parts.py.

Reads lines of JSON, ``[component, config]``, and prints one line for each that is refused.
"""

import asyncio
import importlib
import json
import sys
from typing import Any

from homeassistant.core import HomeAssistant
from homeassistant.helpers import frame

ROOT = "homeassistant.components.mqtt"
EXTRA = frozenset({"origin"})
"""Fields that discovery removes before the check by the schema."""


def schema_of(component: str) -> Any:
    """Return the schema of discovered configs."""
    if component == "tag":
        return importlib.import_module(f"{ROOT}.tag").DISCOVERY_SCHEMA
    module = importlib.import_module(f"{ROOT}.{component}")
    if hasattr(module, "DISCOVERY_SCHEMA"):
        return module.DISCOVERY_SCHEMA
    return module.DISCOVERY_SCHEMA_MODERN


async def check() -> None:
    """Check all lines; in Home Assistant 2025.4, schemas of templates need a running one."""
    if hasattr(frame, "async_setup"):
        frame.async_setup(HomeAssistant(""))
    for line in sys.stdin:
        component, config = json.loads(line)
        try:
            schema_of(component)({key: value for key, value in config.items() if key not in EXTRA})
        except Exception as error:  # noqa: BLE001 - each is the answer
            print(json.dumps([component, config, f"{type(error).__name__}: {error}"]))  # noqa: T201


asyncio.run(check())
