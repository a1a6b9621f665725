"""A robot of a fleet is a robot of the house by its topic."""

import anyio
import pytest
from tests.integrations.vda5050.robot import FleetRobot

from homebot.config import parse_config
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.names import WHERE_IS_ROBOT, GatewayNames
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.devices.services import SubscribeToTopic, SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.graph import Node
from homebot.messages.builtin_interfaces import Time
from homebot.runtime import Runtime

ROOMS = {
    "Hall": {"polygon": [[10.0, 0.0], [14.0, 0.0], [14.0, 5.0], [10.0, 5.0]]},
    "Kitchen": {"polygon": [[14.0, 0.0], [18.0, 0.0], [18.0, 5.0], [14.0, 5.0]]},
}


@pytest.mark.virtual_time
async def test_the_state_of_a_robot_places_it_in_a_room_until_it_is_silent() -> None:
    robot = FleetRobot(x=2.0, y=1.0)
    rosie = {"topic": f"{robot.base}/state", "map_transform": [10.0, 0.0, 0.0]}
    config = parse_config({"robots": {"rosie": rosie}, "places": {"rooms": ROOMS}}, "homebot.toml")
    async with (
        Runtime(config, with_door=False) as runtime,
        Node(runtime.graph, "mqtt", namespace="/gateway") as gateway,
    ):
        inbox = gateway.create_publisher(RawMessage, "/fleet")
        subscribed = SubscribeToTopicResponse(success=True, data_topic="/fleet")

        def subscribe(_request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
            return subscribed

        gateway.create_service(SubscribeToTopic, GatewayNames("mqtt").subscribe, subscribe)
        where = gateway.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        await anyio.sleep(1)

        async def seen() -> str:
            said, now = robot.state(), Time.from_seconds(runtime.graph.clock.now())
            told = {"gateway": "mqtt", "key": said.topic, "address": said.topic, "retained": False, "received_at": now}
            inbox.publish(RawMessage.model_validate({**told, "payload": said.payload}))
            await anyio.sleep(1)
            [pose] = (await where.call(WhereIsRobotRequest())).pose
            return pose.room if pose.counts else ""

        assert await seen() == "Hall"
        robot.x = 5.0
        await anyio.sleep(30)
        assert await seen() == "Kitchen"
        await anyio.sleep(40)
        [pose] = (await where.call(WhereIsRobotRequest())).pose
        assert not pose.counts
