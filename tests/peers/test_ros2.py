"""The link to ROS 2, against pyzeros: another implementation of ROS 2 nodes on Zenoh."""

import json
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, TypeVar

import anyio
from tests.patience import PATIENCE
from tests.ports import reserve_port

from homebot.bridges.ros2.link import serve_link
from homebot.bridges.ros2.robots import RobotsOnWire
from homebot.bridges.ros2.session import open_session
from homebot.bridges.rosbridge.access import ClientAccess
from homebot.devices.client_rights import read_scope
from homebot.devices.robot_owners import RobotOwners
from homebot.graph import Graph, Node
from homebot.messages import String
from homebot.messages.interfaces.settings import RosSettings
from homebot.messages.std_srvs import Trigger

T = TypeVar("T")


async def serve(graph: Graph, address: str, *, task_status: anyio.abc.TaskStatus[None]) -> None:
    table = {"listen": address, "export": ("/house/**",), "import": {"rosie": ("/rosie/**",)}}
    settings = RosSettings.model_validate(table)
    access = ClientAccess("rosie", read_scope(("read", "act: harmless", "robot: rosie")), RobotOwners({"rosie": ()}))
    async with open_session(settings) as session, Node(graph, "ros2") as node:
        node.create_task(session.run)
        robots = RobotsOnWire(settings.imports, {"rosie": access})
        await serve_link(node, session, settings, robots, task_status=task_status)


async def heard(publish: Callable[[], None], receive: Callable[[], Awaitable[T]]) -> T:
    """Return what is received; it is published until then, as a volatile message has no reader at first."""
    with anyio.fail_after(PATIENCE):
        while True:
            publish()
            with anyio.move_on_after(0.2):
                return await receive()


async def test_topics_and_services_go_both_ways() -> None:
    import asyncio_for_robotics as afor  # noqa: PLC0415 - only installed for these tests
    import pyzeros  # noqa: PLC0415 - as above
    import zenoh  # noqa: PLC0415 - as above
    from ros2_pyterfaces.cyclone import all_msgs, all_srvs  # noqa: PLC0415 - as above

    graph, address = Graph(), f"tcp/127.0.0.1:{reserve_port()}"

    async def answer(server: Any) -> None:
        async for asked in server.listen_reliable():
            asked.response.success, asked.response.message = True, "docked"
            asked.send()

    @afor.scoped
    async def meet(app: Node) -> None:
        app.create_service(Trigger, "/house/light", lambda _: Trigger.Response(success=True, message="on"))
        ours, words = app.create_publisher(String, "/house/words"), app.create_subscription(String, "/rosie/words")
        theirs, says = pyzeros.Sub(all_msgs.String, "/house/words"), pyzeros.Pub(all_msgs.String, "/rosie/words")
        light: Any = pyzeros.Client(all_srvs.Trigger, "/house/light")
        dock: Any = pyzeros.Server(all_srvs.Trigger, "/rosie/dock")
        await light.wait_for_service()
        switched = await light.call_async(all_srvs.Trigger.Request())
        assert (switched.success, switched.message) == (True, "on")
        assert (await heard(partial(says.publish, all_msgs.String(data="hello")), words.receive)).data == "hello"
        assert (await heard(partial(ours.publish, String(data="lamp on")), theirs.wait_for_new)).data == "lamp on"
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(answer, dock)
            client = app.create_client(Trigger, "/rosie/dock")
            assert await client.wait_for_service(PATIENCE)
            assert (await client.call(Trigger.Request(), PATIENCE)).message == "docked"
            tasks.cancel_scope.cancel()

    async with anyio.create_task_group() as tasks, Node(graph, "app") as app:
        await tasks.start(partial(serve, graph, address))
        settings = {"mode": "peer", "connect": {"endpoints": [address]}, "listen": {"endpoints": ["tcp/127.0.0.1:0"]}}
        config = zenoh.Config.from_json5(json.dumps(settings | {"scouting": {"multicast": {"enabled": False}}}))
        with (
            zenoh.open(config) as session,
            pyzeros.auto_context(node="brain", namespace="/rosie", zenoh_session=session),
        ):
            await meet(app)
        tasks.cancel_scope.cancel()
