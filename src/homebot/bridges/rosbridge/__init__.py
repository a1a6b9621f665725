"""The door: rosbridge v2 (JSON over WebSocket) for everybody outside the process."""

from homebot.bridges.rosbridge.server import Door
from homebot.bridges.rosbridge.settings import DoorSettings

__all__ = ["Door", "DoorSettings"]
