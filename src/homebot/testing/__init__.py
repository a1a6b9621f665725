"""What tests of homebot, and of programs made with it, need."""

from homebot.testing.gateway import FakeGateway, FakeGatewaySettings
from homebot.testing.house import TestHouse, house_of
from homebot.testing.virtual_time import VirtualTimeLoop

__all__ = ["FakeGateway", "FakeGatewaySettings", "TestHouse", "VirtualTimeLoop", "house_of"]
