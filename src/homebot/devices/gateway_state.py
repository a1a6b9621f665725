"""State of a gateway."""

from __future__ import annotations

from typing import Literal

from homebot.messages.message import Message

__all__ = ["ONLY_OBSERVES", "GatewayState"]

ONLY_OBSERVES = "the gateway only observes; start with --act, or set act = true"


class GatewayState(Message):
    """The state of a gateway: whether it reaches its protocol's world, and whether it may act there.

    Attributes:
        state: ``active`` or ``unavailable``.
        reason: Why it is unavailable, in words.
        acts: Whether it sends commands; a gateway that only observes refuses them.
    """

    state: Literal["active", "unavailable"]
    reason: str
    acts: bool
