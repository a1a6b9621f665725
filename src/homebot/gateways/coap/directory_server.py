"""A resource directory on aiocoap, for devices that register at homebot itself; RFC 9176.

An invalid request is answered with 4.00, and charged to its host; an excessive one with 5.03. A host that registers
another address than its own, or changes or ends the registration of another host, gets 4.03 and is charged. Of a
device that registers simply, without a body, the links are asked for.
"""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from functools import partial
from urllib.parse import urlsplit

import aiocoap
import anyio
import anyio.lowlevel
from aiocoap import resource
from aiocoap.error import RequestEntityIncomplete, RequestEntityTooLarge
from aiocoap.numbers.codes import Code
from aiocoap.pipe import Pipe
from anyio.abc import TaskGroup

from homebot.clock import Clock
from homebot.conventions.coap.endpoint import CoapEndpoint
from homebot.conventions.coap.link_format import WebLink, format_links, parse_links
from homebot.conventions.coap.registry import FORBIDDEN, DirectoryRegistry
from homebot.errors import LinkError, PeerError, RefusedError, WireError
from homebot.gateways.coap.aiocoap_client import CoapClient, limit_requests
from homebot.support.isolation import run_as
from homebot.support.request_limit import RequestLimit
from homebot.wot.coap.content_formats import LINK_FORMAT

__all__ = ["DirectoryServer"]

MAX_ASKED = 8
"""Devices that are asked for their links at once, each host once."""

ANSWERS_WITHIN = 15.0
"""Seconds."""

MAX_BODY = 64 * 1024
"""Bytes of the links of one device."""

MAX_OBSERVERS = 32
"""Observations of one lookup."""


class DirectoryServer:
    """A resource directory.

    Args:
        found: Gets each endpoint that registers, or renews its registration.
        gone: Gets each endpoint after the end of its registration, and the reason.
        admits: Says whether a request of a host is to be read.
        reject: Receives invalid requests: the host, the bytes and the reason.
        requests: Limits the requests.
    """

    def __init__(
        self,
        clock: Clock,
        *,
        found: Callable[[CoapEndpoint], None],
        gone: Callable[[CoapEndpoint, str], None],
        admits: Callable[[str], bool],
        reject: Callable[[str, bytes, str], None],
        requests: RequestLimit,
    ) -> None:
        self.registry = DirectoryRegistry()
        self._clock = clock
        self._found = found
        self._gone = gone
        self._admits = admits
        self._reject = reject
        self._requests = requests
        self._asked: set[str] = set()
        self._has_changed = False
        self._tasks: TaskGroup | None = None
        self._lookups = (
            _Lookup(self.registry.look_up_endpoints, "core.rd-lookup-ep"),
            _Lookup(self.registry.look_up_resources, "core.rd-lookup-res"),
        )

    @asynccontextmanager
    async def open(self, host: str, port: int) -> AsyncIterator[None]:
        """Serve on an address inside the block; raise LinkError if it cannot be listened on."""
        site = resource.Site()
        site.add_resource(
            [".well-known", "core"], resource.WKCResource(site.get_resources_as_linkheader, impl_info=None)
        )
        site.add_resource(["rd"], _Registration(partial(self._answer, self._register)))
        site.add_resource([".well-known", "rd"], _Unlisted(partial(self._answer, self._register_simply)))
        site.add_resource(["rd"], _Registrations(partial(self._answer, self._change)))
        site.add_resource(["rd-lookup", "ep"], self._lookups[0])
        site.add_resource(["rd-lookup", "res"], self._lookups[1])
        try:
            context = await aiocoap.Context.create_server_context(site, bind=(host, port), transports=["udp6"])
        except OSError as exc:
            raise LinkError(f"no resource directory can be served on {host}:{port}: {exc}") from exc
        limit_requests(context, self._requests.admits)
        try:
            async with anyio.create_task_group() as self._tasks:
                self._client = CoapClient(context, ANSWERS_WITHIN)
                yield
                self._tasks.cancel_scope.cancel()
        finally:
            self._tasks = None
            with anyio.CancelScope(shield=True):
                await anyio.lowlevel.checkpoint()
                await context.shutdown()

    def expire(self) -> None:
        """End the expired registrations, and notify observers if anything has changed since the last call."""
        for one in self.registry.expire(self._clock.monotonic()):
            self._gone(one.endpoint, f"its registration was not renewed for {one.parameters['lt']} s")
            self._has_changed = True
        if self._has_changed:
            self._has_changed = False
            for lookup in self._lookups:
                lookup.updated_state()

    def _answer(
        self, handle: Callable[[aiocoap.Message, str], aiocoap.Message], request: aiocoap.Message
    ) -> aiocoap.Message:
        host = str(urlsplit(request.remote.uri_base).hostname)
        if not self._admits(host):
            return aiocoap.Message(code=Code.SERVICE_UNAVAILABLE)
        try:
            return handle(request, host)
        except WireError as exc:
            self._reject(host, request.payload[:200], str(exc))
            return aiocoap.Message(code=Code.BAD_REQUEST, payload=str(exc)[:200].encode())
        except RefusedError as exc:
            self._reject(host, request.payload[:200], str(exc))
            return aiocoap.Message(code=Code.FORBIDDEN if exc.code == FORBIDDEN else Code.SERVICE_UNAVAILABLE)
        except KeyError:
            return aiocoap.Message(code=Code.NOT_FOUND)

    def _register(self, request: aiocoap.Message, host: str) -> aiocoap.Message:
        if request.code != Code.POST:
            return aiocoap.Message(code=Code.METHOD_NOT_ALLOWED)
        path = self._add(_query(request), request.payload, host, request.remote.uri_base)
        return aiocoap.Message(code=Code.CREATED, location_path=tuple(path.split("/")[1:]))

    def _change(self, request: aiocoap.Message, host: str) -> aiocoap.Message:
        """Renew or remove a registration."""
        path = f"/rd/{'/'.join(request.opt.uri_path)}"
        if request.code == Code.POST:
            self._found(self.registry.renew(path, _query(request), host, self._clock.monotonic()).endpoint)
            return aiocoap.Message(code=Code.CHANGED)
        if request.code == Code.DELETE:
            self._gone(self.registry.remove(path, host).endpoint, "it took back its registration")
            self._has_changed = True
            return aiocoap.Message(code=Code.DELETED)
        return aiocoap.Message(code=Code.METHOD_NOT_ALLOWED)

    def _register_simply(self, request: aiocoap.Message, host: str) -> aiocoap.Message:
        """Register a device that sends no links: they are asked for where it is; RFC 9176, section 5.1."""
        query, base = _query(request), request.remote.uri_base
        if request.code != Code.POST:
            return aiocoap.Message(code=Code.METHOD_NOT_ALLOWED)
        if request.payload or "base" in query:
            raise WireError("a simple registration has no links and no base")
        self.registry.check({"base": base, **query})
        if self._tasks is None or host in self._asked or len(self._asked) >= MAX_ASKED:
            raise RefusedError("a simple registration", "too many are asked for their links")
        self._asked.add(host)
        self._tasks.start_soon(run_as, "a simple registration", partial(self._ask_links, query, host, base))
        return aiocoap.Message(code=Code.CHANGED)

    async def _ask_links(self, query: dict[str, str], host: str, base: str) -> None:
        try:
            answer = await self._client.request("GET", f"{base}/.well-known/core", accept=LINK_FORMAT)
            self._add(query, answer.payload, host, base)
        except (LinkError, PeerError) as exc:
            self._reject(host, b"", f"its simple registration failed: {exc}")
        finally:
            self._asked.discard(host)

    def _add(self, query: dict[str, str], links: bytes, host: str, base: str) -> str:
        made = self.registry.register(query, parse_links(links), host, base, self._clock.monotonic())
        self._found(made.endpoint)
        self._has_changed = True
        return made.path


class _Registration(resource.Resource):  # type: ignore[misc]  # the library has no types
    """The resource to register at."""

    rt = "core.rd"
    ct = str(LINK_FORMAT)

    def __init__(self, answer: Callable[[aiocoap.Message], aiocoap.Message]) -> None:
        super().__init__()
        self._answer = answer

    async def render(self, request: aiocoap.Message) -> aiocoap.Message:
        return self._answer(request)

    async def render_to_pipe(self, pipe: Pipe) -> None:
        """Answer a request, of which aiocoap puts any number of blocks together, and knows no gap between them."""
        block = pipe.request.opt.block1
        if block is not None and block.start >= MAX_BODY:
            raise RequestEntityTooLarge
        try:
            await super().render_to_pipe(pipe)
        except ValueError as exc:
            raise RequestEntityIncomplete from exc


class _Unlisted(_Registration):
    """A resource that is not listed."""

    def get_link_description(self) -> None:
        return None


class _Registrations(_Unlisted, resource.PathCapable):  # type: ignore[misc]  # likewise
    """The resources below it, one for each registration."""


class _Lookup(resource.ObservableResource):  # type: ignore[misc]  # likewise
    """A lookup, which can be observed."""

    ct = str(LINK_FORMAT)

    def __init__(self, look_up: Callable[[dict[str, str]], tuple[WebLink, ...]], kind: str) -> None:
        super().__init__()
        self.rt = kind
        self._look_up = look_up

    async def add_observation(self, request: aiocoap.Message, observation: object) -> None:
        """Accept an observation, unless there are too many: then the answer is one that is not observed."""
        if len(self._observations) < MAX_OBSERVERS:
            await super().add_observation(request, observation)

    async def render_get(self, request: aiocoap.Message) -> aiocoap.Message:
        try:
            found = format_links(self._look_up(_query(request)))
        except WireError as exc:
            return aiocoap.Message(code=Code.BAD_REQUEST, payload=str(exc).encode())
        return aiocoap.Message(payload=found, content_format=LINK_FORMAT)


def _query(request: aiocoap.Message) -> dict[str, str]:
    pairs = (one.partition("=") for one in request.opt.uri_query)
    return {name: value for name, _, value in pairs}
