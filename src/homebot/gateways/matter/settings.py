"""The table ``[gateways.NAME]`` of a Matter gateway."""

from __future__ import annotations

from typing import Annotated
from urllib.parse import urlsplit

from pydantic import Field, field_validator

from homebot.gateways.base import GatewaySettings

__all__ = ["MatterGatewaySettings"]


class MatterGatewaySettings(GatewaySettings):
    """The settings of a Matter gateway.

    Attributes:
        url: The WebSocket of the Matter server.
        max_nodes: Nodes that are known at once; a further one is refused and counted.
    """

    url: str = "ws://127.0.0.1:5580/ws"
    max_nodes: Annotated[int, Field(ge=1, le=10_000)] = 500

    @field_validator("url")
    @classmethod
    def _check_url(cls, url: str) -> str:
        found = urlsplit(url)  # raises ValueError itself
        if found.scheme not in {"ws", "wss", "http", "https"} or not found.hostname:
            raise ValueError("the address of a Matter server is written like ws://127.0.0.1:5580/ws")
        if found.username is not None or found.password is not None:
            raise ValueError("a Matter server has no user and no password; leave them out")
        return url
