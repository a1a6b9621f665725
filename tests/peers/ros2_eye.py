"""A robot as a node of ROS 2 that publishes what its light sensor sees, and asks which of two lamps that is."""

import asyncio
import sys
from types import SimpleNamespace
from typing import Any

import asyncio_for_robotics as afor
import pyzeros
import zenoh
from ros2_pyterfaces.cyclone.all_msgs import Illuminance

from homebot.devices.query.term_messages import QueryTerm
from homebot.devices.services import QueryDevices
from homebot.features.identify.messages import IdentifyDevice, IdentifyDeviceGoal
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.type_hash import type_hash
from homebot.messages.unique_identifier_msgs import UUID

ACTION = "/devices/identify/_action"
LISTENING = "@ros2_lv/0/*/*/*/MS/*/%/ros2/%rosie%light/**"
ID = UUID(uuid=bytes([7]) * 16)


def client(name: str, kind: Any) -> Any:
    """Return what calls a service of homebot's own type."""
    service: Any = SimpleNamespace(get_type_name=lambda: kind.ros_type, hash_rihs01=lambda: type_hash(kind))
    service.Response = SimpleNamespace(deserialize=lambda data: message_from_cdr(kind.Response, data))
    return pyzeros.Client(service, name)


async def call(caller: Any, request: Any) -> Any:
    await caller.wait_for_service()
    return await caller.call_async(SimpleNamespace(serialize=lambda: message_to_cdr(request)))


async def see() -> None:
    """Publish what is seen of the lamp in the hall, and of the one behind the wall."""
    publisher, query = pyzeros.Pub(Illuminance, "/rosie/light"), client("/discovery/query", QueryDevices)
    while True:
        words = QueryTerm(kind="words", text="on light")
        found = await call(query, QueryDevices.Request(query=(words,), limit=9))
        lit = {one.device.id for one in found.results}
        publisher.publish(Illuminance(illuminance=40.0 + 120.0 * ("hall_lamp" in lit) + 0.5 * ("kitchen_lamp" in lit)))
        await asyncio.sleep(0.1)


async def main(candidates: str) -> None:
    async with afor.Scope(), asyncio.TaskGroup() as tasks:
        seeing = tasks.create_task(see())
        while not list(session.liveliness().get(LISTENING)):  # noqa: ASYNC110 - no event of this process
            await asyncio.sleep(0.1)
        goal = IdentifyDeviceGoal(candidates=candidates, topic="/rosie/light", at_night=True)
        sending = client(f"{ACTION}/send_goal", IdentifyDevice.SendGoal)
        sent = await call(sending, IdentifyDevice.SendGoal.Request(goal_id=ID, goal=goal))
        assert sent.accepted
        getting = client(f"{ACTION}/get_result", IdentifyDevice.GetResult)
        got = await call(getting, IdentifyDevice.GetResult.Request(goal_id=ID))
        sys.stdout.write(got.result.message)
        seeing.cancel()


config = zenoh.Config.from_file("robot.json5")
config.insert_json5("queries_default_timeout", "90000")  # milliseconds, within which the result comes
with zenoh.open(config) as session, pyzeros.auto_context("brain", session, "/rosie"):
    asyncio.run(main(sys.argv[1]))
