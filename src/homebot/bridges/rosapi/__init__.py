"""``/rosapi``: the services by which programs outside look around on the graph."""

from homebot.bridges.rosapi.services import RosApi

__all__ = ["RosApi"]
