"""The one adapter for aiocoap's client: requests, observations and multicast questions, each bounded.

Blocks of a long answer are put together here, up to a limit; aiocoap would go on as long as the server does.
"""

from __future__ import annotations

import asyncio
import os
import re
import socket
import sys
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Iterable, Iterator
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass
from functools import partial
from typing import Final, cast

import aiocoap
import aiocoap.error
import anyio
import anyio.lowlevel
from aiocoap.message import UndecidedRemote
from aiocoap.numbers.codes import Code
from aiocoap.util import hostportjoin, hostportsplit

from homebot.errors import LinkError, RefusedError, UsageError, WireError
from homebot.gateways.address_guard import AddressGuard, OwnAddressError
from homebot.gateways.coap.settings import CoapCredentials
from homebot.support.connect_errors import connect_problem
from homebot.support.unanswered import SENT_REQUESTS, awaiting_answer

MAX_BODY: Final = 256 * 1024
"""Longest answer that is put together of blocks."""

_BLOCKS_WITHIN: Final = 120.0
"""Seconds in which the blocks of one answer are asked for: a slow radio takes a tenth of a second for each."""

_MAX_PAYLOAD: Final = 1024
"""Bytes that one message has at most; RFC 7252, section 4.6. A longer answer is asked for in blocks.

aiocoap's directory notifies in one message however long it is, and aiocoap's client cuts it at 4,096 bytes in silence.
"""

_FIRST_RESPONSE: Final = 0x40
"""Codes below are of requests, and 0 is empty; RFC 7252, section 3."""

_DATAGRAM: Final = 65_536
"""Bytes of the longest datagram."""

_MAX_AGE: Final = 60.0
_MARGIN: Final = 10.0
"""Seconds after the age of a notification at which the observation is registered again; RFC 7641, section 3.3.1."""

LEISURE: Final = 5.0
"""Seconds for answers to a multicast question; RFC 7252, section 8.2."""

_TRIES = 5
"""Sendings of a request that the network refuses: it tells the next sender, whomever that sends to."""

_ROUNDS = 5
_ZONE = re.compile(r"\A([^/]*//[^/\[]*\[[^\]%]*)%25")
"""The zone of a link-local address as RFC 6874 spells it; aiocoap takes it without the escape."""

_GROUPS = {"ipv4": "224.0.1.187", "ipv6": "ff02::fd"}
_METHODS = {name: getattr(Code, name) for name in ("GET", "POST", "PUT", "DELETE", "FETCH", "PATCH", "iPATCH")}
_METHODS["IPATCH"] = _METHODS["iPATCH"]


@dataclass(frozen=True, slots=True)
class CoapAnswer:
    """A successful response, with the number of its content format; None if it names none."""

    payload: bytes
    content_format: int | None


@dataclass(frozen=True, slots=True)
class GroupAnswer:
    """One answer to a multicast question.

    Attributes:
        host: The address that it came from, with its scope where it is link-local.
        is_whole: Whether that is all of it.
    """

    host: str
    port: int
    payload: bytes
    is_whole: bool


class CoapClient:
    """A CoAP endpoint that asks.

    To one endpoint there is one request at a time that was not acknowledged yet: aiocoap keeps to NSTART = 1 of RFC
    7252, section 4.7.

    Args:
        patience: Seconds to wait for a response.
        guard: The guard of this computer's addresses; None for addresses that the owner configured.
    """

    def __init__(self, context: aiocoap.Context, patience: float, guard: AddressGuard | None = None) -> None:
        self._context = context
        self._patience = patience
        self._guard = guard

    def guarded_by(self, guard: AddressGuard | None) -> CoapClient:
        """Return the same endpoint with another guard."""
        return CoapClient(self._context, self._patience, guard)

    @classmethod
    @asynccontextmanager
    async def open(cls, patience: float, credentials: Iterable[CoapCredentials]) -> AsyncIterator[CoapClient]:
        """Open an endpoint for the block.

        Raises:
            LinkError: There is no network.
            UsageError: The credentials cannot be used; says which.
        """
        try:
            context = await aiocoap.Context.create_client_context()
        except OSError as exc:
            raise LinkError(f"no CoAP endpoint can be opened: {exc}") from exc
        _drop_requests(context)
        try:
            for credential in credentials:
                _load(context, credential)
            yield cls(context, patience)
        finally:
            with anyio.CancelScope(shield=True):
                for _ in range(_ROUNDS):  # aiocoap sends in tasks of its own, which end in two or three of them
                    await anyio.lowlevel.checkpoint()
                await context.shutdown()

    async def request(
        self,
        method: str,
        uri: str,
        payload: bytes = b"",
        *,
        content_format: int | None = None,
        accept: int | None = None,
    ) -> CoapAnswer:
        """Send a request, and return the response.

        Raises:
            LinkError: No answer in time.
            RefusedError: The answer is a client or server error.
            WireError: The answer is too long, or breaks the rules of blocks.
        """
        if method.upper() not in _METHODS:
            raise RefusedError(f"{method[:20]} {uri[:200]}", "CoAP has no such method")
        message = _message(_METHODS[method.upper()], uri, payload, content_format, accept)
        with _translate(uri):
            first = await self._send(message)
            return await self._whole(uri, accept, _check(uri, first))

    async def observe(self, uri: str, accept: int | None = None) -> AsyncGenerator[CoapAnswer, None]:
        """Yield the current state of a resource, and each later one; the newest where they come faster than they go.

        Registers again where nothing came for longer than the last state may be kept.

        Raises:
            LinkError: No answer in time.
            RefusedError: The resource cannot be observed, or is gone.
            WireError: As :meth:`request`.
        """
        while True:
            with _translate(uri):
                message = _message(Code.GET, uri, b"", None, accept)
                message.opt.observe = 0
                request = await self._begin_request(message)
                notifications = aiter(request.observation)
                try:
                    response = _check(uri, await self._answered(request))
                    if response.opt.observe is None:
                        raise RefusedError(f"observing {uri[:200]}", "it cannot be observed")
                    while response is not None:
                        if len(response.payload) > _MAX_PAYLOAD:
                            yield await self.request("GET", uri, accept=accept)
                        else:
                            yield await self._whole(uri, accept, response)
                        response = await self._next(notifications, response)
                        response = None if response is None else _check(uri, response)
                finally:
                    if not request.observation.cancelled:
                        request.observation.cancel()
            await anyio.sleep(1.0)  # a server that ends each observation at once is not asked at full speed

    async def ask_group(self, version: str, interface: str, port: int, take: Callable[[GroupAnswer], None]) -> None:
        """Ask all CoAP nodes on one network interface for their resources, and give each answer to *take*.

        Args:
            version: ``ipv4`` or ``ipv6``.
            take: Receives each answer; never raises. Other messages are passed over.

        Raises:
            LinkError: The question could not be sent.
        """
        message = aiocoap.Message(code=Code.GET, _mtype=aiocoap.NON, _mid=int.from_bytes(os.urandom(2), "big"))
        message.token = os.urandom(8)
        message.opt.uri_path = (".well-known", "core")
        with _group_socket(version, interface) as opened:
            loop = asyncio.get_running_loop()
            try:
                await loop.sock_sendto(opened, message.encode(), (_GROUPS[version], port))
                with anyio.move_on_after(LEISURE):
                    while True:
                        data, address = await loop.sock_recvfrom(opened, _DATAGRAM)
                        answer = _group_answer(message.token, data, address)
                        if answer is not None:
                            take(answer)
                        await anyio.lowlevel.checkpoint()  # others have a turn during a flood
            except OSError as exc:
                raise LinkError(f"no {version} multicast on the interface {interface!r}: {exc}") from exc

    async def _send(self, message: aiocoap.Message) -> aiocoap.Message:
        """Send a request; again where the network refused it, which it may have said of another device on Linux."""
        tries = 1 if message.code == Code.POST else _TRIES  # POST may do harm when it comes twice
        for _ in range(tries - 1):
            try:
                return await self._answered(await self._begin_request(message))
            except aiocoap.error.NetworkError as exc:
                if type(exc) is not aiocoap.error.NetworkError:
                    raise
                message = message.copy(token=b"", mid=None)
        return await self._answered(await self._begin_request(message))

    async def _begin_request(self, message: aiocoap.Message) -> aiocoap.interfaces.Request:
        """Begin a request; the look-up of a name is waited for here, so that it can be cancelled."""
        with anyio.fail_after(self._patience):
            if self._guard is not None and isinstance(message.remote, UndecidedRemote):
                host, port = hostportsplit(message.remote.hostinfo)
                address = await self._guard.resolve(host, port or 0)
                message.remote = UndecidedRemote(message.remote.scheme, hostportjoin(address, port))
            await self._context.find_remote_and_interface(message)
        return self._context.request(message, handle_blockwise=False)

    async def _answered(self, request: aiocoap.interfaces.Request) -> aiocoap.Message:
        with awaiting_answer(), anyio.fail_after(self._patience):
            return cast("aiocoap.Message", await request.response)

    async def _next(
        self, notifications: AsyncIterator[aiocoap.Message], last: aiocoap.Message
    ) -> aiocoap.Message | None:
        """Return the next notification; None if it is time to register again."""
        age = _MAX_AGE if last.opt.max_age is None else float(last.opt.max_age)
        with anyio.move_on_after(max(age, 1.0) + _MARGIN):
            return await anext(notifications, None)
        return None

    async def _whole(self, uri: str, accept: int | None, first: aiocoap.Message) -> CoapAnswer:
        """Ask for the other blocks of an answer; RFC 7959, section 2.4."""
        body, block = bytearray(first.payload), first.opt.block2
        number, until = 0, anyio.current_time() + _BLOCKS_WITHIN
        while block is not None and block.more:
            number += 1
            if len(body) != number * block.size:
                raise WireError(f"the answer of {uri[:200]} has a block that is not full and not the last")
            if anyio.current_time() > until:
                raise LinkError(f"{uri[:200]} takes longer than {_BLOCKS_WITHIN:g} s for one answer")
            message = _message(Code.GET, uri, b"", None, accept)
            message.opt.block2 = (number, False, block.size_exponent)
            response = _check(uri, await self._send(message))
            block = response.opt.block2
            if block is None or block.block_number != number or response.opt.etag != first.opt.etag:
                raise WireError(f"the answer of {uri[:200]} changed while its blocks were asked for")
            body += response.payload
            if len(body) > MAX_BODY:
                raise WireError(f"the answer of {uri[:200]} is longer than {MAX_BODY} bytes")
        return CoapAnswer(bytes(body), None if first.opt.content_format is None else int(first.opt.content_format))


def _drop_requests(context: aiocoap.Context) -> None:
    """Drop the requests that come to *context*.

    aiocoap remembers each request for four minutes, of a client as well, so that a flood would take all memory.
    """
    for interface in context.request_interfaces:
        port = getattr(getattr(interface, "token_interface", None), "message_interface", None)
        if port is not None and hasattr(port, "datagram_msg_received"):
            port.datagram_msg_received = partial(_receive, port.datagram_msg_received)


def _receive(receive: Callable[..., None], data: bytes, control: object, flags: int, sender: object) -> None:
    if not (len(data) > 1 and 0 < data[1] < _FIRST_RESPONSE):
        receive(data, control, flags, sender)


def _group_answer(token: bytes, data: bytes, address: tuple[str, int]) -> GroupAnswer | None:
    """Return the answer to the question with *token* that *data* is, or None."""
    try:
        message = aiocoap.Message.decode(data)
    except (aiocoap.error.Error, ValueError, IndexError):
        return None
    if message.token != token or not message.code.is_successful():
        return None
    block = message.opt.block2
    host = address[0]
    if "%" not in host and len(address) > 3 and address[3]:
        host = f"{host}%{socket.if_indextoname(address[3])}"
    return GroupAnswer(host, address[1], message.payload, block is None or not block.more)


def _message(code: Code, uri: str, payload: bytes, content_format: int | None, accept: int | None) -> aiocoap.Message:
    try:
        message = aiocoap.Message(code=code, uri=_ZONE.sub(r"\1%", uri), payload=payload)
    except (aiocoap.error.Error, ValueError) as exc:
        raise WireError(f"{uri[:200]!a} is not an address: {exc}") from exc
    if content_format is not None:
        message.opt.content_format = content_format
    if accept is not None:
        message.opt.accept = accept
    return message


def _check(uri: str, response: aiocoap.Message) -> aiocoap.Message:
    if response.code.is_successful():
        return response
    detail = response.payload[:100].decode(errors="replace") if response.payload.isascii() else ""
    text = f"{response.code.dotted} {response.code.name_printable}" + (
        f": {detail}" if detail.isprintable() and detail else ""
    )
    raise RefusedError(uri[:200], text, int(response.code))


@contextmanager
def _translate(uri: str) -> Iterator[None]:
    """Raise errors of aiocoap as ours."""
    uri = uri[:200]
    try:
        yield
    except (TimeoutError, aiocoap.error.TimeoutError) as exc:
        raise LinkError(f"{uri} does not answer") from exc
    except (aiocoap.error.NotObservable, aiocoap.error.ObservationCancelled) as exc:
        raise RefusedError(f"observing {uri}", "it cannot be observed") from exc
    except OwnAddressError as exc:
        raise exc.refusal_of(uri) from None
    except (aiocoap.error.NetworkError, aiocoap.error.LibraryShutdown, OSError) as exc:
        SENT_REQUESTS.get().is_unanswered = False  # the network did not take it
        cause = exc if isinstance(exc, OSError) else exc.__cause__  # which the library's text does not tell
        reason = connect_problem(cause) if isinstance(cause, OSError) else str(exc)
        raise LinkError(f"{uri} cannot be reached: {reason}") from exc
    except aiocoap.error.Error as exc:
        raise WireError(f"{uri}: {exc!r}"[:300]) from exc


def _group_socket(version: str, interface: str) -> socket.socket:
    family = socket.AF_INET if version == "ipv4" else socket.AF_INET6
    opened = socket.socket(family, socket.SOCK_DGRAM)
    try:
        index = socket.if_nametoindex(interface)
        opened.setblocking(False)  # noqa: FBT003 - the socket module's own
        if version == "ipv4":
            request = socket.inet_aton(_GROUPS["ipv4"]) + b"\0" * 4 + index.to_bytes(4, sys.byteorder)
            opened.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, request)
        else:
            opened.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_IF, index)
    except OSError as exc:
        opened.close()
        raise LinkError(f"the interface {interface!r} cannot be used for {version} multicast: {exc}") from exc
    return opened


def _load(context: aiocoap.Context, credentials: CoapCredentials) -> None:
    if credentials.oscore:
        given: dict[str, object] = {"oscore": {"basedir": credentials.oscore.rstrip("/") + "/"}}
    else:
        psk = {"ascii": credentials.key.get_secret_value()}
        given = {"dtls": {"psk": psk, "client-identity": {"ascii": credentials.identity}}}
    try:
        context.client_credentials.load_from_dict({credentials.uri: given})
    except (ValueError, KeyError, OSError, ImportError) as exc:
        raise UsageError(f"the credentials for {credentials.uri} cannot be used: {exc}") from exc
