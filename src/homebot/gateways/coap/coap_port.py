"""CoAP as the protocol of things.

Source: W3C Working Group Note (draft) "Web of Things (WoT) CoAP Binding": default methods, ``cov:method``,
``cov:observe``.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Awaitable, Callable
from contextlib import aclosing
from typing import TYPE_CHECKING, Final

from homebot.conventions.coap.endpoint import SCHEMES
from homebot.errors import RefusedError
from homebot.gateways.things.port import ThingPayload
from homebot.wot.binding import RequestBinding
from homebot.wot.coap.content_formats import coap_formats, content_format_of, content_type_of
from homebot.wot.thing import Form

if TYPE_CHECKING:
    from homebot.gateways.coap.aiocoap_client import CoapAnswer, CoapClient

__all__ = ["COAP_BINDING", "CoapPort"]

COAP_BINDING: Final = RequestBinding(SCHEMES, ("cov:observe", "coap:observe", ""), coap_formats)

NOT_ALLOWED: Final = 0x85
NOT_ACCEPTABLE: Final = 0x86
_OTHER = {"PUT": "POST", "POST": "PUT"}


class CoapPort:
    """The way to one thing; see :class:`homebot.gateways.things.port.ThingPort`.

    Args:
        admits: Returns whether a notification of the thing is to be read.
    """

    binding = COAP_BINDING

    def __init__(self, client: CoapClient, admits: Callable[[], bool]) -> None:
        self._client = client
        self._admits = admits

    async def read(self, form: Form) -> ThingPayload:
        """Return the value of a resource, in the declared format if it has that."""
        method = form.method or "GET"
        try:
            answer = await self._client.request(method, form.href, accept=_accepted(form))
        except RefusedError as exc:
            if exc.code != NOT_ACCEPTABLE:
                raise
            answer = await self._client.request(method, form.href)
        return _payload(answer)

    async def write(self, form: Form, payload: bytes) -> None:
        """Send *payload*; a property that takes no PUT is written by POST, and the other way round."""
        method = form.method or ("PUT" if "writeproperty" in form.ops else "POST")
        content_format = content_format_of(form.content_type) if payload else None
        try:
            await self._client.request(method, form.href, payload, content_format=content_format)
        except RefusedError as exc:
            if exc.code != NOT_ALLOWED or method not in _OTHER or "writeproperty" not in form.ops:
                raise
            await self._client.request(_OTHER[method], form.href, payload, content_format=content_format)

    async def observe(
        self, form: Form, read_current: Callable[[], Awaitable[None]]
    ) -> AsyncGenerator[ThingPayload, None]:
        """Yield the states of a resource, beginning with the current one."""
        del read_current
        async with aclosing(self._client.observe(form.href)) as answers:
            async for answer in answers:
                if self._admits():
                    yield _payload(answer)


def _accepted(form: Form) -> int | None:
    return content_format_of(form.response_type or form.content_type)


def _payload(answer: CoapAnswer) -> ThingPayload:
    return ThingPayload(answer.payload, content_type_of(answer.content_format))
