"""The names of devices that broadcast."""

from homebot.conventions.bluetooth.broadcast import Advertisement, Broadcast
from homebot.gateways.ble.known_device import KnownDevice
from homebot.gateways.ble.settings import BleDeviceSettings


def test_the_name_by_its_model_counts_more_than_the_one_that_it_advertises() -> None:
    """All thermometers of SwitchBot call themselves ``WoSensorTH``."""
    advertisement = Advertisement("C0:00:00:00:12:34", -60, "WoSensorTH")
    device = KnownDevice(advertisement.address, BleDeviceSettings(), None, 0.0)
    device.update(advertisement, None, 0.0)
    assert device.describe(signal=False).name == "WoSensorTH"
    for broadcast in (Broadcast(name="Meter 1234"), None):
        device.update(advertisement, broadcast, 0.0)
        assert device.describe(signal=False).name == "Meter 1234"
