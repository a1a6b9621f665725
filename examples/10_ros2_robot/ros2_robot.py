"""A robot as a node of ROS 2: it says where it is, asks for the nearest lamp that is off, and turns it on."""

import asyncio
from types import SimpleNamespace
from typing import Any

import asyncio_for_robotics as afor
import pyzeros
import zenoh
from ros2_pyterfaces.cyclone.all_msgs import Header, Point, Pose, PoseStamped

from homebot.devices.command_messages import CommandDevices
from homebot.devices.query.term_messages import QueryTerm
from homebot.devices.services import QueryDevices
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.type_hash import type_hash


async def call(name: str, kind: Any, **values: Any) -> Any:
    service: Any = SimpleNamespace(get_type_name=lambda: kind.ros_type, hash_rihs01=lambda: type_hash(kind))
    service.Response = SimpleNamespace(deserialize=lambda data: message_from_cdr(kind.Response, data))
    client = pyzeros.Client(service, name)
    await client.wait_for_service()
    return await client.call_async(SimpleNamespace(serialize=lambda: message_to_cdr(kind.Request(**values))))


async def main() -> None:
    async with afor.Scope():
        pose, query = pyzeros.Pub(PoseStamped, "/rosie/pose"), QueryTerm(kind="words", text="off light near rosie")
        while not (found := await call("/discovery/query", QueryDevices, query=(query,), limit=1)).success:
            pose.publish(PoseStamped(Header(frame_id="map"), Pose(Point(3.5, 1.0, 0.0))))  # counts for 5 seconds
            await asyncio.sleep(0.5)  # homebot may not listen yet
        if found.results:
            found = await call("/devices/command", CommandDevices, target=found.results[0].device.id, command="on")
        print(found.message or f"{found.results[0].device} is on: {found.outcome}")


with zenoh.open(zenoh.Config.from_file("robot.json5")) as session, pyzeros.auto_context("brain", session, "/rosie"):
    asyncio.run(main())
