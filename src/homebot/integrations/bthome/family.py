"""The family of simulated sensors that broadcast BTHome v2."""

from homebot.house.ble_family import BleFamily


class BTHomeFamily(BleFamily):
    """Sensors."""

    kinds = frozenset({"contact", "lux", "motion", "power_meter", "thermostat"})
    device = "homebot.integrations.bthome.simulated:BroadcastingSensor"
