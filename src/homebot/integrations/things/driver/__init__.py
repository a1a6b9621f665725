"""The driver for things that serve a W3C Thing Description over HTTP."""

from homebot.integrations.things.driver.driver import ThingDriver

__all__ = ["ThingDriver"]
