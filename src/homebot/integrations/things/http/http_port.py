"""HTTP as the protocol of things.

Source: W3C Recommendation "Web of Things (WoT) Thing Description 1.1", sections 5.3.3 (security) and 8.3.1 (HTTP), and
W3C "Web of Things (WoT) HTTP Binding": default methods and ``sse``.
"""

from collections.abc import AsyncGenerator, Awaitable, Callable, Sequence
from contextlib import AsyncExitStack, suppress
from types import TracebackType
from typing import Final, Self

import anyio
from yarl import URL

from homebot.errors import PeerError, RefusedError
from homebot.gateways.address_guard import AddressGuard
from homebot.gateways.http_address import parse_url
from homebot.gateways.http_client import HttpAnswer, HttpClient
from homebot.gateways.password_settings import HttpLogin, LoginScheme, ThingLogin
from homebot.integrations.things.formats.binding import RequestBinding
from homebot.integrations.things.formats.thing import Form, Thing
from homebot.integrations.things.http.thing_device import ThingPayload

HTTP_BINDING: Final = RequestBinding(frozenset({"http", "https"}), ("sse",))

WATCH_EVERY: Final = 60.0
"""Seconds between checks of a thing that pushes its values, as a lost connection may go unnoticed."""


class HttpThingPort:
    """The HTTP :class:`homebot.integrations.things.http.thing_device.ThingPort` of one thing; use it as ``async with``.

    Args:
        guard: The guard of this computer's addresses; None if its own directory lists the thing.
    """

    binding = HTTP_BINDING

    def __init__(self, thing: Thing, logins: Sequence[ThingLogin], guard: AddressGuard | None) -> None:
        self._thing = thing
        self._guard = guard
        self._logins = logins
        self._clients: dict[HttpLogin | None, HttpClient] = {}
        self._stack = AsyncExitStack()
        self._read_forms = {
            push.href: read
            for affordance in thing.affordances
            for push in HTTP_BINDING.push_forms(affordance)
            for read in HTTP_BINDING.read_forms(affordance)[:1]
        }

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        self._clients.clear()
        with anyio.CancelScope(shield=True):
            await self._stack.aclose()

    async def read(self, form: Form) -> ThingPayload:
        """Return the current value at the address of *form*."""
        method = form.method if form.method in {"GET", "POST"} and "writeproperty" not in form.ops else "GET"
        return _payload(await self._request(method, form), form)

    async def write(self, form: Form, payload: bytes) -> None:
        """Send *payload*, by default by PUT to a property and by POST to an action."""
        method = form.method if form.method != "GET" else ""
        default = "POST" if "invokeaction" in form.ops else "PUT"
        await self._request(method or default, form, payload)

    async def observe(
        self, form: Form, read_current: Callable[[], Awaitable[None]]
    ) -> AsyncGenerator[ThingPayload, None]:
        """Yield pushed values; the current value is read after the start, as a server only pushes later changes."""
        client = await self._client(form)
        async with client.events(form.href) as events:
            await read_current()
            async for event in events:
                yield ThingPayload(event.data.encode(errors="replace"), form.response_type or form.content_type)

    async def watch(self, confirm: Callable[[], None]) -> None:
        """Read a value of a thing that pushes values at intervals, until cancelled."""
        form = next(iter(self._read_forms.values()), None)
        while True:
            await anyio.sleep(WATCH_EVERY)
            if form is not None:
                with suppress(PeerError):  # this is an answer too
                    await self.read(form)
                confirm()

    async def _request(self, method: str, form: Form, payload: bytes = b"") -> HttpAnswer:
        client = await self._client(form)
        return await client.request(
            method,
            form.href,
            body=payload or None,
            content_type=form.content_type if payload else "",
            accept=form.response_type or form.content_type,
        )

    async def _client(self, form: Form) -> HttpClient:
        """Return the client for the address of *form*."""
        login = self._login(form)
        client = self._clients.get(login)
        if client is None:
            made = HttpClient(guard=self._guard, login=login)
            client = self._clients[login] = await self._stack.enter_async_context(made)
        return client

    def _login(self, form: Form) -> HttpLogin | None:
        where = parse_url(form.href)
        wanted = [self._thing.security[name] for name in form.security if name in self._thing.security]
        wanted = [scheme for scheme in wanted if scheme != "nosec"]
        if len(wanted) > 1:
            raise RefusedError("credentials for the thing", "it wants several at once, which is not supported")
        scheme = next(iter(wanted), "")
        if scheme not in {"", "basic", "bearer"}:
            raise RefusedError("credentials for the thing", f"it wants {scheme[:40]!a}, which is not supported")
        known = _known_at(where, self._logins)
        if known is None or not scheme:
            return None
        if known.scheme not in {None, scheme}:
            raise RefusedError("credentials for the thing", f"it wants {scheme!a}, and {known.scheme} is configured")
        return _http_login(known, where, "basic" if scheme == "basic" else "bearer")


def login_at(where: URL, logins: Sequence[ThingLogin]) -> HttpLogin | None:
    """Return the credentials for reading descriptions at an address, if the configuration says how they are sent."""
    known = _known_at(where, logins)
    return None if known is None or known.scheme is None else _http_login(known, where, known.scheme)


def _known_at(where: URL, logins: Sequence[ThingLogin]) -> ThingLogin | None:
    return next((login for login in logins if login.is_for(where.host or "", where.port)), None)


def _http_login(login: ThingLogin, where: URL, scheme: LoginScheme) -> HttpLogin:
    return HttpLogin(str(where.origin()), scheme, login.user, login.password)


def _payload(answer: HttpAnswer, form: Form) -> ThingPayload:
    return ThingPayload(answer.body, answer.content_type or form.response_type or form.content_type)
