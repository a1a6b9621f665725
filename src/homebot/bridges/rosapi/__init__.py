"""``/rosapi``: the services by which programs outside look around on the graph."""

from homebot.bridges.rosapi.rosapi import RosApi

__all__ = ["RosApi"]
