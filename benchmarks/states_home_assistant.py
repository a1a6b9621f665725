"""Runs inside Home Assistant's venv: its MQTT integration with a listener to all changes of lights.

``python states_home_assistant.py PORT LAMPS`` prints a JSON line when it knows the lamps, and one with the seconds of
processor time that it took from there until each has its last level.
"""

from __future__ import annotations

import asyncio
import json
import logging
import sys
import tempfile
import time

from homeassistant.core import Event, callback

from ingest_home_assistant import booted, entry_of

LAST_LEVEL = 255  # of 255, which is 254 of 254


async def main(port: int, count: int) -> None:
    logging.basicConfig(level=logging.CRITICAL, stream=sys.stderr)
    with tempfile.TemporaryDirectory() as directory:
        hass = await booted(directory)
        levels: dict[str, int | None] = {}

        @callback
        def on_change(event: Event) -> None:
            state = event.data["new_state"]
            if state is not None and state.domain == "light":
                levels[state.entity_id] = state.attributes.get("brightness")

        hass.bus.async_listen("state_changed", on_change)
        await hass.config_entries.async_add(entry_of(port))
        while len(levels) < count:
            await asyncio.sleep(0.05)
        await asyncio.sleep(1.0)  # what it does after the last lamp
        print(json.dumps({"known": len(levels)}), flush=True)
        spent = time.process_time()
        levels.clear()
        while list(levels.values()) != [LAST_LEVEL] * count:
            await asyncio.sleep(0.02)
        print(json.dumps({"cpu": time.process_time() - spent}), flush=True)
        await hass.async_stop(force=True)


asyncio.run(main(int(sys.argv[1]), int(sys.argv[2])))
