"""The least that anybody would write: aiomqtt, one pydantic model, and a dict.

``python ingest_bare.py PORT COUNT`` prints one JSON line, as the other ingest workers. It reads no templates, makes no
codecs, subscribes to no states, and tells nobody.
"""

from __future__ import annotations

import asyncio
import json
import resource
import sys
import time

import aiomqtt
from pydantic import BaseModel, ConfigDict


class Device(BaseModel):
    model_config = ConfigDict(extra="ignore")

    identifiers: list[str]
    name: str


class Light(BaseModel):
    model_config = ConfigDict(extra="ignore")

    unique_id: str
    command_topic: str
    state_topic: str
    supported_color_modes: list[str]
    device: Device


async def main(port: int, count: int) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    started, spent = time.perf_counter(), time.process_time()
    lights: dict[str, Light] = {}
    async with aiomqtt.Client("127.0.0.1", port) as client:
        await client.subscribe("homeassistant/light/+/+/config")
        async for message in client.messages:
            lights[message.topic.value] = Light.model_validate_json(message.payload)
            if len(lights) == count:
                break
    seconds, cpu = time.perf_counter() - started, time.process_time() - spent
    grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) * 1024
    print(
        json.dumps(
            {"found": len(lights), "seconds": seconds, "cpu": cpu, "process": time.process_time(), "memory": grown}
        )
    )


asyncio.run(main(int(sys.argv[1]), int(sys.argv[2])))
