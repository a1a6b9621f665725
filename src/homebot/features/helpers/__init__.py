"""Helpers: values of a house that no device has, such as whether it is on vacation."""

from typing import Final

from homebot.feature import Feature, FeatureTable
from homebot.rights import OfferedService, Right

KEEP_VALUES: Final = OfferedService("/helpers/keep", Right.MANAGE, "homebot/srv/KeepHelperValues")

FEATURE: Final = Feature(
    name="helpers",
    server="homebot.features.helpers.value_keeper:start",
    services=(KEEP_VALUES,),
    messages=("homebot.features.helpers.messages",),
    tables={
        "helpers": FeatureTable(
            "homebot.features.helpers.settings:gateway_of_helpers",
            section="gateways",
            plugin="homebot.features.helpers.helpers_gateway:HelpersGateway",
        )
    },
)
