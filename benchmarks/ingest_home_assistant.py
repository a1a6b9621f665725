"""Runs inside Home Assistant's venv: sets up its MQTT integration against a broker full of retained configs.

``python ingest_home_assistant.py PORT COUNT`` prints one JSON line: lights found, seconds and processor seconds until
then, and bytes of memory that they took. Nothing of homebot is imported, and nothing of Home Assistant is replaced but
the web server and other integrations that MQTT asks to be there.
"""

from __future__ import annotations

import asyncio
import inspect
import json
import logging
import resource
import sys
import tempfile
import time
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

from homeassistant import bootstrap, config_entries, core, loader
from homeassistant.const import __version__
from homeassistant.core import HomeAssistant
from homeassistant.setup import async_setup_component

PATIENCE = 120.0
"""Seconds without another light after which no more are waited for; of ten thousand the first comes late."""

TAKEN_FOR_LOADED = (
    "http",
    "websocket_api",
    "api",
    "auth",
    "file_upload",
    "frontend",
    "recorder",
    "repairs",
    "diagnostics",
)


async def main(port: int, count: int) -> None:
    logging.basicConfig(level=logging.CRITICAL, stream=sys.stderr)
    with tempfile.TemporaryDirectory() as directory:
        hass = await booted(directory)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        started, spent = time.perf_counter(), time.process_time()
        await hass.config_entries.async_add(entry_of(port))
        found, seconds, cpu = await _settled(hass, count, started, spent)
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
        answer = {"found": found, "seconds": seconds, "cpu": cpu, "process": time.process_time(), "memory": grown}
        print(json.dumps({"version": __version__, **answer}), flush=True)
        await hass.async_stop(force=True)


async def booted(directory: str) -> HomeAssistant:
    hass = HomeAssistant(directory)
    Path(directory, "configuration.yaml").write_text("")
    hass.config.skip_pip = True
    loader.async_setup(hass)
    hass.config_entries = config_entries.ConfigEntries(hass, {})
    load = getattr(bootstrap, "async_load_base_functionality", None) or bootstrap.load_registries
    await load(hass)
    hass.http = MagicMock()
    for component in TAKEN_FOR_LOADED:
        hass.config.components.add(component)
    running = core.CoreState.running
    hass.set_state(running) if hasattr(hass, "set_state") else setattr(hass, "state", running)
    await async_setup_component(hass, "homeassistant", {})
    return hass


def entry_of(port: int) -> config_entries.ConfigEntry:
    """What the user's form makes, in the fields that this version has."""
    given: dict[str, Any] = {
        "domain": "mqtt",
        "title": "bench",
        "data": {"broker": "127.0.0.1", "port": port, "birth_message": {}},
        "options": {},
        "version": 1,
        "minor_version": 1,
        "source": "user",
        "unique_id": None,
        "discovery_keys": {},
        "subentries_data": None,
    }
    wanted = inspect.signature(config_entries.ConfigEntry.__init__).parameters
    return config_entries.ConfigEntry(**{key: value for key, value in given.items() if key in wanted})


async def _settled(hass: HomeAssistant, count: int, started: float, spent: float) -> tuple[int, float, float]:
    found, ended, cpu = -1, started, spent
    while found < count and time.perf_counter() - ended < PATIENCE:
        await asyncio.sleep(0.02)
        lights = len(hass.states.async_entity_ids("light"))
        if lights != found:
            found, ended, cpu = lights, time.perf_counter(), time.process_time()
    return found, ended - started, cpu - spent


if __name__ == "__main__":
    asyncio.run(main(int(sys.argv[1]), int(sys.argv[2])))
