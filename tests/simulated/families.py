"""The simulated servers and radios of the tests, as families of devices that a house may have."""

from pathlib import Path
from typing import Final

from homebot.house.family import ServedFamily, family_of

FAMILIES: Final = {
    "ble_light": "tests.simulated.ble_family:BluetoothLightFamily",
    "bthome": "tests.integrations.bthome.simulated.family:BTHomeFamily",
    "coap": "tests.simulated.coap_family:CoapFamily",
    "esphome": "tests.integrations.esphome.simulated.family:EsphomeFamily",
    "home_assistant": "tests.integrations.homeassistant.simulated.family:HomeAssistantFamily",
    "homekit": "tests.integrations.homekit.simulated.family:HomekitFamily",
    "hue": "tests.integrations.hue.simulated.family:HueFamily",
    "matter": "tests.integrations.matter.simulated.family:MatterFamily",
    "matter_bridge": "tests.integrations.matter.simulated.family:BridgedMatterFamily",
    "matter_plug": "tests.integrations.matter.simulated.family:MatterPlugFamily",
    "nfc": "tests.simulated.nfc.family:TagFamily",
    "shelly_http": "tests.integrations.shelly.simulated.family:ShellyHttpFamily",
    "wled": "tests.integrations.wled.simulated.family:WledFamily",
}
"""The dialects that a description of a house states, by short names."""

PROTOCOLS: Final = Path(__file__).with_name("protocols.toml")
"""A house with a device of each."""


def families_with(kind: str) -> dict[str, type[ServedFamily]]:
    """Return the families that have devices of *kind*, by short names."""
    loaded = ((name, family_of(dialect)) for name, dialect in FAMILIES.items())
    return {name: family for name, family in loaded if isinstance(family, type) and kind in family.kinds}
