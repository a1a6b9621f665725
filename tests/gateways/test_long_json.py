"""Long JSON: other tasks run while it is parsed."""

import json

import anyio
import anyio.lowlevel

from homebot.gateways.long_json import parse_long_json

LIMIT = 8 * 1024 * 1024


async def test_other_tasks_run_while_a_long_page_is_parsed() -> None:
    thing = {"id": "urn:1", "properties": {str(number): {"forms": [{"href": "/x"}]} for number in range(50)}}
    page = json.dumps({"members": [thing] * 1500}).encode()
    turns = 0

    async def take_turns() -> None:
        nonlocal turns
        while True:
            await anyio.lowlevel.checkpoint()
            turns += 1

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(take_turns)
        assert await parse_long_json(page, LIMIT) == json.loads(page)
        tasks.cancel_scope.cancel()
    assert turns >= len(page) // (80 * 1024)
