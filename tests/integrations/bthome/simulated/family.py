"""The family of simulated sensors that broadcast BTHome v2."""

from tests.simulated.ble_family import BleFamily


class BTHomeFamily(BleFamily):
    """Sensors."""

    kinds = frozenset({"contact", "lux", "motion", "power_meter", "thermostat"})
    device = "tests.integrations.bthome.simulated.sensors:BroadcastingSensor"
