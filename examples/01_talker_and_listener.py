"""Two nodes and a topic: the computation graph alone, without any device."""

import asyncio

from homebot import Graph, Node
from homebot.messages import String


async def main() -> None:
    """Publish three messages and receive them."""
    graph = Graph()
    async with Node(graph, "talker") as talker, Node(graph, "listener") as listener:
        heard = listener.create_subscription(String, "chatter")
        publisher = talker.create_publisher(String, "chatter")
        for word in ("one", "two", "three"):
            publisher.publish(String(data=word))
        talker.close()
        for _ in range(3):
            print("heard", (await heard.receive()).data)


if __name__ == "__main__":
    asyncio.run(main())
