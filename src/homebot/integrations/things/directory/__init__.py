"""The gateway to a directory of things: the devices that a W3C Thing Description Directory lists."""

from homebot.integrations.things.directory.gateway import ThingDirectoryGateway
from homebot.integrations.things.directory.settings import ThingDirectorySettings

__all__ = ["ThingDirectoryGateway", "ThingDirectorySettings"]
