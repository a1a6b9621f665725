"""Apple Home: devices of the house as accessories of a HomeKit bridge, for the app, Siri, HomePods and widgets.

Exports: lamps, switches, plugs, coverings, climate, sensors and batteries by their types and rooms; locks, garage doors
and all else that always asks by name alone; scenes and routines as switches. Commands are those of the client
``apple``, with the rights ``ordinary`` and the names of the configuration; a device that did not obey, or is away,
"does not respond".

Transport: HAP over TCP by HAP-python, on the address of the configuration. The keys of pairings, the setup code and the
numbers of accessories are in a file beside the index that only its owner reads.

Source: HomeKit Accessory Protocol Specification, Non-Commercial Version, Release R2.

Tested against: aiohomekit, over loopback. Not with Apple's products.

Not done: fans, cameras, buttons, speakers and televisions, alarm panels, valves, adaptive lighting.
"""

from typing import Final

from homebot.feature import Feature, FeatureTable, RunFacts, Verb
from homebot.rights import OfferedService, Right

GET_PAIRING: Final = OfferedService("/homekit_bridge/pairing", Right.MANAGE)
UNPAIR: Final = OfferedService("/homekit_bridge/unpair", Right.MANAGE)

PAIRINGS_FILE: Final = "homekit_bridge.pairings.json"
"""The name of the file, beside that of the directory."""


def _is_wanted(house: RunFacts) -> bool:
    return house.table("homekit_bridge") is not None and not house.is_rehearsal


FEATURE: Final = Feature(
    name="homekit_bridge",
    services=(GET_PAIRING, UNPAIR),
    runs="homebot.features.homekit_bridge.serving:serve_bridges",
    is_wanted=_is_wanted,
    tables={"homekit_bridge": FeatureTable("homebot.features.homekit_bridge.settings:read_homekit_bridge")},
    messages=("homebot.features.homekit_bridge.messages",),
    verbs={
        "homekit": Verb(
            "show the code that pairs the house with Apple Home, and what it has there; end the pairings",
            "homebot.features.homekit_bridge.command:add_arguments",
            after="pair",
        )
    },
)
