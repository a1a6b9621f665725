"""The protocol that a thing is used over, as far as the thing needs it."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from dataclasses import dataclass
from typing import Protocol

from homebot.wot.binding import RequestBinding
from homebot.wot.thing import Form

__all__ = ["ThingPayload", "ThingPort"]


@dataclass(frozen=True, slots=True)
class ThingPayload:
    """A payload that a thing sent.

    Attributes:
        content_type: Its type as the answer names it; empty if it names none.
    """

    data: bytes
    content_type: str = ""


class ThingPort(Protocol):
    """A protocol of requests and responses, with the credentials of one thing.

    Every call is limited in time and in the length of the answer. It raises :class:`homebot.errors.LinkError` where the
    thing does not answer, :class:`homebot.errors.RefusedError` where it answers with no, and
    :class:`homebot.errors.WireError` where its answer breaks the rules of the protocol.

    Attributes:
        binding: The forms that it can use.
    """

    @property
    def binding(self) -> RequestBinding: ...  # noqa: D102 - see Attributes

    async def read(self, form: Form) -> ThingPayload:
        """Return the present value at the address of *form*."""
        ...

    async def write(self, form: Form, payload: bytes) -> None:
        """Send *payload* to the address of *form*; return when it was accepted.

        Args:
            form: Says the method and the content type as well.
            payload: Empty for an action without input.
        """
        ...

    def observe(self, form: Form, read_current: Callable[[], Awaitable[None]]) -> AsyncIterator[ThingPayload]:
        """Yield pushed values, until the caller has enough; the end of the observation is an error.

        Args:
            read_current: Reads the current value; called whenever an observation has begun that does not start with it,
                so that no change before that is lost.
        """
        ...
