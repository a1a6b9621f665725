"""The driver for things that serve a W3C Thing Description over HTTP."""

from homebot.gateways.drivers.thing.driver import HttpThingDriver, ThingDriver

__all__ = ["HttpThingDriver", "ThingDriver"]
