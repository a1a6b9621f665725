"""ROS 2 robots, over Zenoh in the layout of ``rmw_zenoh``: topics, services and nodes of both sides."""

from typing import Final

from homebot.feature import Feature, Verb

FEATURE: Final = Feature(
    name="ros2",
    over_zenoh="homebot.features.ros2.link:serve",
    verbs={
        "router": Verb(
            "run only the router between homebot and ROS 2 robots; make its certificate",
            "homebot.features.ros2.command:add_arguments",
            after="join",
        )
    },
)
