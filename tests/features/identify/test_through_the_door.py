"""A robot outside sends the pictures of its camera through the door, and learns which lamp it sees."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from io import BytesIO

import anyio
import pytest
from tests.bridges.conftest import Peer
from tests.control.conftest import Home, obey_after
from tests.features.identify.conftest import Room, served
from tests.patience import PATIENCE
from websockets.asyncio.client import connect

from homebot.bridges.rosbridge import RosbridgeServer, RosbridgeSettings
from homebot.devices.device_lookup import DeviceLookup
from homebot.graph import Node

pytestmark = pytest.mark.slow
Pillow = pytest.importorskip("PIL.Image")

LAMP = (200, 120, 80, 80)
"""Where ``lamp1`` is in the picture, as x, y, width and height."""
PERIOD = 0.1


async def film(room: Room, peer: Peer) -> None:
    """Send frames of 320x240 in which ``lamp1`` is bright, and the others light the wall a little; until cancelled.

    Some frames are cut off, and some are of another size, in which the region is not.
    """
    lookup = DeviceLookup(room.home.app)
    x, y, width, height = LAMP
    while True:
        lit = {one.name: one.states[0].value.plain() is True for one in await lookup.devices() if one.states}
        wall = 60 + 6 * sum(lit.values()) + room.random.gauss(0, 2)
        scene = Pillow.new("L", (320, 240), int(wall))
        scene.paste(int(wall + 90 * lit["Lamp1"]), (x, y, x + width, y + height))
        data = BytesIO()
        fault = room.random.random()
        (scene.resize((160, 120)) if fault > 0.8 else scene).save(data, "JPEG")
        content = data.getvalue()[: 500 if fault < 0.2 else None]
        picture = {"format": "jpeg", "data": b64encode(content).decode()}
        await peer.send("publish", topic="/rosie/image", msg=picture)
        await anyio.sleep(PERIOD)


async def goal(peer: Peer, **args: object) -> None:
    fields = {"candidates": "light in hall", "topic": "/rosie/image", "region": LAMP, **args}
    await peer.send(
        "send_action_goal",
        id="goal",
        action="/devices/identify",
        action_type="homebot/action/IdentifyDevice",
        args=fields,
        feedback=True,
    )


@asynccontextmanager
async def camera_on(home: Home) -> AsyncIterator[tuple[Room, str]]:
    """Give a room with three lamps that a camera films, and the address of the door."""
    room = Room(home)
    room.is_seeing = False
    await room.lamps(0, 0, 0)
    for key in room.effects:
        home.behaviours[key] = obey_after(0.2)
    async with served(room), Node(home.graph, "door") as node, anyio.create_task_group() as tasks:
        door = RosbridgeServer(node, RosbridgeSettings(port=0))
        await tasks.start(door.run)
        address = f"ws://127.0.0.1:{door.port}"
        async with connect(address, proxy=None) as camera:
            eye = Peer(camera)
            await eye.tell("advertise", topic="/rosie/image", type="sensor_msgs/CompressedImage")
            tasks.start_soon(film, room, eye)
            yield room, address
            tasks.cancel_scope.cancel()


async def test_pictures_of_a_camera_show_which_lamp_it_sees(home: Home) -> None:
    async with camera_on(home) as (room, address), connect(address, proxy=None) as robot:
        before, peer, looks = await room.is_on(), Peer(robot), 0
        await goal(peer)
        while (frame := await peer.receive())["op"] == "action_feedback":
            looks += 1
        assert (frame["status"], frame["values"]["message"]) == (4, "Lamp1 is in view")
        assert looks == len(frame["values"]["looks"]) >= 5
        assert abs(frame["values"]["candidates"][1]["effect"] - 96) < 40
        assert await room.is_on() == before


async def test_a_robot_that_is_gone_leaves_everything_as_before(home: Home) -> None:
    async with camera_on(home) as (room, address):
        before = await room.is_on()
        async with connect(address, proxy=None) as robot:
            peer = Peer(robot)
            await goal(peer)
            for _ in range(2):
                await peer.receive()
            assert await room.is_on() != before
        with anyio.fail_after(PATIENCE):
            while room.store:  # noqa: ASYNC110 - a goal of another client is no event here
                await anyio.sleep(PERIOD)
        assert await room.is_on() == before
