"""A Home Assistant that is announced on the network."""

from __future__ import annotations

import anyio
import pytest
from tests.gateways.drivers.driver_host import KeepingHost

from homebot.conventions.dns_sd.found_service import FoundService
from homebot.devices.gateway_messages import Command
from homebot.devices.value import Value
from homebot.errors import UnableError
from homebot.gateways.drivers.base import DriverSettings
from homebot.gateways.drivers.homeassistant.driver import HomeAssistantDriver

KIND = "_home-assistant._tcp.local."
TOLD = {"location_name": "Villa", "version": "2024.3.3", "internal_url": "http://192.168.1.20:8123"}


@pytest.mark.parametrize(
    ("told", "url"), [(TOLD, "http://192.168.1.20:8123"), ({}, "http://ha.local:8123")], ids=["told", "bare"]
)
async def test_it_says_how_homebot_gets_to_its_devices(told: dict[str, str], url: str) -> None:
    host = KeepingHost()
    service = FoundService(f"Home.{KIND}", "Home", KIND, "ha.local.", 8123, ("192.168.1.20",), told)
    driver = HomeAssistantDriver(service, DriverSettings(), host)
    with anyio.move_on_after(0.01):
        await driver.run()
    (device,) = host.devices
    assert device.parts == ()
    assert f'url = "{url}" in [gateways.homeassistant]' in device.metadata["next_step"]
    assert "Long-lived access tokens" in device.metadata["next_step"]
    with pytest.raises(UnableError, match="its own gateway"):
        await driver.perform(Command(key="x", part="", capability="on_off", value=Value.of(True)))
