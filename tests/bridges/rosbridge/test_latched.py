"""Latched messages: bounded over all clients, the oldest of the client with the most first."""

from tests.bridges.conftest import OpenHouse, Peer

from homebot.bridges.rosbridge import RosbridgeSettings
from homebot.devices.health import HealthRequest


async def kept(peer: Peer, *topics: str) -> dict[str, int]:
    """Return the length of the text that each topic keeps; answers and messages are sent alternately."""
    found = {}
    for topic in topics:
        await peer.send("subscribe", topic=topic)
    for _ in ("before the first message", *topics):
        await peer.send("call_service", id="end", service="/rosapi/get_time")
        while (frame := await peer.receive()).get("id") != "end":
            found[frame["topic"]] = len(frame["msg"]["data"])
    return found


async def latch(peer: Peer, topic: str, size: int) -> None:
    await peer.send("advertise", topic=topic, type="std_msgs/String", latch=True)
    await peer.tell("publish", topic=topic, msg={"data": "x" * size})


async def test_the_client_with_the_most_loses_its_oldest_latched_message(open_house: OpenHouse) -> None:
    settings = RosbridgeSettings(port=0, max_kept_bytes_of_all=100_000)
    async with open_house(settings) as house, house.peer() as robot, house.peer() as flood, house.peer() as late:
        await latch(robot, "/map", 30_000)
        for number in range(4):
            await latch(flood, f"/flood{number}", 20_000)
        assert await kept(late, "/map", "/flood0", "/flood1") == {"/map": 30_000, "/flood1": 20_000}
        counts = {one.name: one.count for one in house.server.health(HealthRequest()).counts}
        assert counts["latched_displaced"] == 1


async def test_what_a_client_kept_is_released_with_its_topics_and_with_itself(open_house: OpenHouse) -> None:
    async with open_house() as house:
        account = house.server._shared.kept
        async with house.peer() as robot:
            for topic in ("/a", "/b"):
                await latch(robot, topic, 1000)
                await latch(robot, topic, 2000)
            before = account.waiting
            await robot.tell("unadvertise", topic="/a")
            assert account.waiting == before // 2 > 2000
        async with house.peer() as late:
            await late.settle()
            assert (account.waiting, len(account.clients)) == (0, 1)
