"""The door: rosbridge v2 (JSON over WebSocket) for programs outside the process."""

from homebot.bridges.rosbridge.server import Door
from homebot.bridges.rosbridge.settings import ClientToken, DoorSettings, Scope

__all__ = ["ClientToken", "Door", "DoorSettings", "Scope"]
