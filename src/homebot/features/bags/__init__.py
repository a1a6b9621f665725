"""Bags: messages of topics in MCAP files, as rosbag2 of ROS 2 writes and reads them."""

from typing import Final

from homebot.feature import Feature, Verb

FEATURE: Final = Feature(
    name="bags",
    verbs={
        "bag": Verb(
            "record and play bags of ROS 2 (MCAP files)", "homebot.features.bags.command:add_arguments", after="record"
        )
    },
)
