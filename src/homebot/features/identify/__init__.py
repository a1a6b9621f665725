"""Identification of the device in view among several: each changes in a code of its own, and a sensor looks."""

from typing import Final

from homebot.feature import Feature, Verb
from homebot.rights import OfferedService, Right

IDENTIFY_DEVICE: Final = OfferedService("/devices/identify", Right.ACT, "homebot/action/IdentifyDevice")

VALUES: Final = "identify/values"
"""The store of values to put back."""

FEATURE: Final = Feature(
    name="identify",
    server="homebot.features.identify.identify_server:IdentifyStarter",
    services=(IDENTIFY_DEVICE,),
    stores=(VALUES,),
    verbs={
        "identify": Verb(
            "find which of several devices a sensor sees: they blink, and it looks",
            "homebot.features.identify.command:add_arguments",
            after="do",
        ),
        "verify": Verb(
            "check whether a device is the one that a sensor sees",
            "homebot.features.identify.command:add_verify_arguments",
            after="identify",
        ),
    },
    messages=("homebot.features.identify.messages",),
    tools="homebot.features.identify.agent_tools:add_tools",
)
