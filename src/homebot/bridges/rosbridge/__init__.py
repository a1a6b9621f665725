"""The server of rosbridge v2 (JSON over WebSocket) for programs outside the process."""

from homebot.bridges.rosbridge.server import RosbridgeServer
from homebot.bridges.rosbridge.settings import ClientToken, RosbridgeSettings, Scope

__all__ = ["ClientToken", "RosbridgeServer", "RosbridgeSettings", "Scope"]
