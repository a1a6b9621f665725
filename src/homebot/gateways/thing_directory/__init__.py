"""The gateway to a directory of things: the devices that a W3C Thing Description Directory lists."""

from homebot.gateways.thing_directory.gateway import ThingDirectoryGateway
from homebot.gateways.thing_directory.settings import ThingDirectorySettings

__all__ = ["ThingDirectoryGateway", "ThingDirectorySettings"]
