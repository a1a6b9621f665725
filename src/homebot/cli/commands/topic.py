"""``homebot topic list`` and ``homebot topic info``."""

from __future__ import annotations

import argparse

from homebot.cli.directory import GraphEntity, entities, no_such_topic, topic_type
from homebot.cli.door_client import DoorClient
from homebot.cli.with_client import with_client

__all__ = ["info", "list_topics"]

_ENDS = {"publisher": "Publisher", "subscription": "Subscription"}


def list_topics(options: argparse.Namespace) -> int:
    """Print every topic, one a line."""

    async def run(door: DoorClient) -> int:
        topics = {
            one.name: one.type
            for one in await entities(door)
            if one.kind in _ENDS and (options.all or not one.is_hidden)
        }
        for name, ros_type in topics.items():
            print(f"{name} [{ros_type}]" if options.show_types else name)
        return 0

    return with_client(options, run)


def info(options: argparse.Namespace) -> int:
    """Print a topic's type and how many use it, or each of them."""

    async def run(door: DoorClient) -> int:
        ros_type = await topic_type(door, options.topic)
        if not ros_type:
            raise await no_such_topic(door, options.topic)
        name = options.topic if options.topic.startswith("/") else f"/{options.topic}"
        ends = await entities(door, name=name)
        print(f"Type: {ros_type}")
        for kind, title in _ENDS.items():
            users = [one for one in ends if one.kind == kind]
            print(f"{title} count: {len(users)}")
            if options.verbose:
                print("".join(f"\n{_details(one, title)}" for one in users), end="\n" if users else "")
        return 0

    return with_client(options, run)


def _details(end: GraphEntity, title: str) -> str:
    return (
        f"Node: {end.node}\n"
        f"Topic type: {end.type}\n"
        f"Endpoint type: {title.upper()}\n"
        f"QoS profile:\n"
        f"  Reliability: {end.reliability.upper()}\n"
        f"  History (Depth): {end.history.upper()} ({end.depth})\n"
        f"  Durability: {end.durability.upper()}\n"
        f"  Lifespan: {_span(end.lifespan)}\n"
        f"  Deadline: {_span(end.deadline)}\n"
        f"  Liveliness: {end.liveliness.upper()}\n"
        f"  Liveliness lease duration: {_span(end.liveliness_lease_duration)}\n"
    )


def _span(seconds: float) -> str:
    return f"{seconds:g} s" if seconds else "Infinite"
