"""The Zenoh session of the bridge, which alone knows the library, but for the key expressions of rights.

Zenoh calls back on threads of its own: all that comes from there waits for the event loop in a bounded queue.
"""

from __future__ import annotations

import asyncio
import atexit
import json
import ssl
import threading
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager, suppress
from functools import partial
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import anyio
import zenoh
import zenoh.ext
from anyio import to_thread

from homebot.bridges.zenoh.lanes import Lanes
from homebot.errors import HomebotError, UsageError
from homebot.graph.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy
from homebot.mqtt.certificate import load_certificate
from homebot.support.logger import get_logger

if TYPE_CHECKING:
    from homebot.bridges.zenoh.rights import WireRights
    from homebot.messages.interfaces.settings import RosSettings

LOST = "ros2.lost"

_log = get_logger(node="/ros2")

_MAX_WAITING = 1000
"""Samples and queries that wait for the event loop, a long one as many of them; more are lost and counted."""

_LONG = 65_536  # bytes

_MAX_TOKENS_WAITING = 20_000
"""The same for tokens, of which all of a large robot come at once."""

_CLOSING, _CLOSING_AT_EXIT, _HEARTBEAT = 0.8, 2.0, 0.5  # seconds; rmw_zenoh has the same heartbeat
_FETCHING = 5.0  # seconds, as in zenoh-bridge-ros2dds
_RETRY = {"period_init_ms": 500, "period_max_ms": 1000}  # up to 4 s of Zenoh are most of the five that are allowed
_ENCODING = "application/cdr"
_TIMEOUT = b"Timeout"
"""The answer of Zenoh itself if there is none in time."""


class Declared(Protocol):
    """A declaration on the session."""

    def undeclare(self) -> object:
        """Take it back."""


class WirePublisher(Declared, Protocol):
    """A writer of samples."""

    def put(self, payload: bytes, *, attachment: bytes) -> object:
        """Send a sample."""


class WireSample(NamedTuple):
    """A message as it arrives."""

    payload: bytes
    attachment: bytes


class WireQuery:
    """A request as it arrives, which must be answered."""

    def __init__(self, query: Any, lanes: Lanes) -> None:
        self._query, self._lanes = query, lanes
        self.payload = b"" if query.payload is None else bytes(query.payload)
        self.attachment = b"" if query.attachment is None else bytes(query.attachment)

    def reply(self, encode: Callable[[], bytes], attachment: bytes) -> None:
        """Answer with the response that *encode* returns, which takes half a second for all devices of a large house.

        Both are done on a thread, away from the event loop; a ``HomebotError`` of *encode* is the answer too.
        """
        query, lanes = self._query, self._lanes

        def answer() -> None:
            try:
                with lanes.working:
                    payload = encode()
            except HomebotError as exc:
                query.reply_err(str(exc))
            else:
                query.reply(query.key_expr, payload, encoding=_ENCODING, attachment=attachment)

        self._end(answer, 0)

    def refuse(self, problem: str) -> None:
        """Answer with an error, which rmw_zenoh only logs."""
        self._end(partial(self._query.reply_err, problem), len(problem))

    def _end(self, answer: Callable[[], object], size: int) -> None:
        query = self._query

        def end() -> None:
            with suppress(zenoh.ZError):  # the caller has left
                answer()
            query.drop()

        # the attachment ends with the id of the client
        self._lanes.make(self.attachment[-16:], end, size, instead=query.drop)


class _KeepingPublisher:
    """A writer of samples none of which Zenoh drops: it waits for a peer instead, on a thread."""

    def __init__(self, publisher: WirePublisher, lanes: Lanes) -> None:
        self._publisher, self._lanes = publisher, lanes

    def put(self, payload: bytes, *, attachment: bytes) -> object:
        def put() -> None:
            with suppress(zenoh.ZError):  # it was taken back meanwhile
                self._publisher.put(payload, attachment=attachment)

        return self._lanes.make(self, put, len(payload))

    def undeclare(self) -> object:
        return self._lanes.make(self, self._publisher.undeclare, 0, instead=self._publisher.undeclare)


class ZenohSession:
    """An open session.

    Attributes:
        domain: The ROS domain.
        nodes: Numbers for the nodes that use it.
        panicked: Set when Zenoh panicked in a call: each later one would, too, so another session is needed.
    """

    def __init__(self, session: Any, domain: int) -> None:
        """Use :func:`open_session` instead."""
        self.domain = domain
        self._session = session
        self._loop = asyncio.get_running_loop()
        self._lock = threading.Lock()
        self._waiting = 0
        self._calls: asyncio.Queue[tuple[Callable[..., None], tuple[object, ...]]] = asyncio.Queue()
        self._lost = 0
        self._lanes = Lanes(lambda: self._to_loop(self.panicked.set))
        self.nodes = count()
        self.panicked = asyncio.Event()
        self.id = str(session.zid())

    @property
    def lost(self) -> int:
        """Samples, queries and tokens that came faster than they were taken, and messages that could not be sent."""
        return self._lost + self._lanes.refused + self._lanes.failed

    @property
    def is_alone(self) -> bool:
        """True if no router that it connects to lets it in."""
        return not self._session.info.routers_zid()

    def probe(self) -> None:
        """Make a call that shows a panic in one of Zenoh's own threads, in :attr:`panicked`."""
        self._lanes.make("probe", lambda: self.declare_token("homebot/probe").undeclare(), 0)

    def end_calls(self) -> None:
        """Make no further call to a peer."""
        self._lanes.close()

    async def run(self) -> None:
        """Make the calls for the others until cancelled; in a task, so that they may start tasks."""
        logged = 0
        while True:
            call, values = await self._calls.get()
            call(*values)
            if self._calls.empty() and self.lost > logged:
                logged = self.lost
                problem = self._lanes.problem or "messages of others came faster than they were taken"
                _log.warning(LOST, lost=logged, problem=problem)
            await asyncio.sleep(0)  # others have their turn

    def declare_token(self, text: str) -> Declared:
        """Tell the others of an entity."""
        declared: Declared = self._session.liveliness().declare_token(text)
        return declared

    def watch_tokens(self, key: str, on_token: Callable[[str, bool], None]) -> Declared:
        """Call back with each token of the others that is there, comes, or goes (False)."""

        def arrived(sample: Any) -> None:
            is_there = sample.kind == zenoh.SampleKind.PUT
            self._offer(partial(on_token, str(sample.key_expr)), is_there, most=_MAX_TOKENS_WAITING)

        declared: Declared = self._session.liveliness().declare_subscriber(key, arrived, history=True)
        return declared

    def publish(self, key: str, qos: QoSProfile) -> WirePublisher:
        """Return a writer of samples as rmw_zenoh has it; of latched ones it keeps the last."""
        is_latched = qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        is_reliable = qos.reliability is ReliabilityPolicy.RELIABLE
        blocks = is_reliable and qos.history is HistoryPolicy.KEEP_ALL
        miss = zenoh.ext.MissDetectionConfig(heartbeat=None, sporadic_heartbeat=_HEARTBEAT)
        publisher: WirePublisher = zenoh.ext.declare_advanced_publisher(
            self._session,
            key,
            encoding=_ENCODING,
            congestion_control=zenoh.CongestionControl.BLOCK if blocks else zenoh.CongestionControl.DROP,
            cache=zenoh.ext.CacheConfig(qos.queue_depth) if is_latched else None,
            publisher_detection=is_latched,
            sample_miss_detection=miss if is_latched and is_reliable else None,
        )
        return _KeepingPublisher(publisher, self._lanes) if blocks else publisher

    def subscribe(self, key: str, qos: QoSProfile, on_sample: Callable[[WireSample], None]) -> Declared:
        """Call back with each sample of others, and those that are latched."""
        is_latched = qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
        is_reliable = qos.reliability is ReliabilityPolicy.RELIABLE
        history = zenoh.ext.HistoryConfig(detect_late_publishers=True, max_samples=qos.queue_depth)
        recovery = zenoh.ext.RecoveryConfig(periodic_queries=None, heartbeat=True)

        def arrived(sample: Any) -> None:
            attachment = b"" if sample.attachment is None else bytes(sample.attachment)
            payload = bytes(sample.payload)
            self._offer(on_sample, WireSample(payload, attachment), len(payload))

        declared: Declared = zenoh.ext.declare_advanced_subscriber(
            self._session,
            key,
            arrived,
            allowed_origin=zenoh.Locality.REMOTE,
            history=history if is_latched else None,
            recovery=recovery if is_latched and is_reliable else None,
        )
        return declared

    def fetch(self, key: str, on_sample: Callable[[WireSample], None], peer: str) -> None:
        """Call back with each sample that the session *peer* has kept for late readers at *key*."""

        def replied(reply: Any) -> None:
            if reply.ok is not None:
                payload = bytes(reply.ok.payload)
                self._offer(on_sample, WireSample(payload, b""), len(payload))

        def get() -> None:
            self._session.get(
                key,
                replied,
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
                accept_replies=zenoh.ReplyKeyExpr.ANY,
                timeout=_FETCHING,
            )

        self._lanes.make(("ask", peer), get, 0)

    def serve(self, key: str, on_query: Callable[[WireQuery], None]) -> Declared:
        """Call back with each request of others."""

        def arrived(query: Any) -> None:
            asked = WireQuery(query, self._lanes)
            if not self._offer(on_query, asked, len(asked.payload)):
                asked.refuse("homebot has too many requests at once; ask again later")

        declared: Declared = self._session.declare_queryable(
            key, arrived, complete=True, allowed_origin=zenoh.Locality.REMOTE
        )
        return declared

    async def ask(
        self, key: str, payload: bytes, attachment: bytes | None, longest: float, peer: str = ""
    ) -> bytes | str | None:
        """Return the first response, the text of an error, or None if no node serves or answers within *longest*.

        Args:
            attachment: None for zenoh-bridge-ros2dds, which takes none, and whose services are not complete to Zenoh.
            peer: The session that is asked; by default *key* stands for it.
        """
        answer: asyncio.Future[bytes | str | None] = self._loop.create_future()
        cancellation: Any = zenoh.CancellationToken()

        def settle(value: bytes | str | None) -> None:
            if not answer.done():
                answer.set_result(value)

        def replied(reply: Any) -> None:
            if reply.ok is not None:
                self._to_loop(settle, bytes(reply.ok.payload))
            elif (problem := bytes(reply.err.payload)) != _TIMEOUT:
                self._to_loop(settle, problem.decode(errors="replace"))

        def get() -> None:
            if answer.done():  # the caller has given up: it is not sent late
                return
            try:
                self._session.get(
                    key,
                    zenoh.handlers.Callback(replied, lambda: self._to_loop(settle, None)),
                    target=zenoh.QueryTarget.ALL if attachment is None else zenoh.QueryTarget.ALL_COMPLETE,
                    consolidation=zenoh.ConsolidationMode.NONE,
                    timeout=longest,
                    payload=payload,
                    encoding=_ENCODING,
                    attachment=attachment,
                    cancellation_token=cancellation,
                )
            except zenoh.ZError:
                self._to_loop(settle, None)

        if not self._lanes.make(("ask", peer or key), get, len(payload)):
            return None
        try:
            with anyio.move_on_after(longest):
                return await answer
        finally:
            answer.cancel()
            cancellation.cancel()
        return None

    def _offer(self, call: Callable[[Any], None], value: object, size: int = 0, most: int = _MAX_WAITING) -> bool:
        """Let the event loop *call* with *value* of *size* bytes; return False if *most* wait already."""
        share = 1 + size // _LONG
        with self._lock:
            if self._waiting >= most:
                self._lost += 1
                return False
            self._waiting += share
        self._to_loop(self._deliver, call, value, share)
        return True

    def _deliver(self, call: Callable[[Any], None], value: object, share: int) -> None:
        with self._lock:
            self._waiting -= share
        call(value)

    def _to_loop(self, call: Callable[..., None], *values: object) -> None:
        with suppress(RuntimeError):  # the loop is closed
            self._loop.call_soon_threadsafe(self._calls.put_nowait, (call, values))


@asynccontextmanager
async def open_session(settings: RosSettings, rights: WireRights) -> AsyncIterator[ZenohSession]:
    """Open a session in which only messages that *rights* allow pass, and close it at the end, within a second.

    Raises:
        UsageError: It cannot listen, or a value is not allowed by Zenoh.
    """
    try:
        session: Any = await to_thread.run_sync(_open, settings, rights)
    except zenoh.ZError as exc:
        raise UsageError(f"[ros] listen or connect: {exc}") from exc
    opened = ZenohSession(session, settings.domain)
    try:
        yield opened
    finally:
        opened.end_calls()
        # A thread of its own, that ends with the program: anyio's would be waited for.
        closing = asyncio.Event()
        loop = asyncio.get_running_loop()
        thread = threading.Thread(target=_close, args=(session, loop, closing), daemon=True)
        thread.start()
        with anyio.move_on_after(_CLOSING, shield=True) as limit:
            await closing.wait()
        if limit.cancelled_caught:  # a thread that comes back from Zenoh while Python ends is killed, and all with it
            atexit.register(thread.join, _CLOSING_AT_EXIT)


def _close(session: Any, loop: asyncio.AbstractEventLoop, closed: asyncio.Event) -> None:
    try:
        with suppress(zenoh.ZError):  # a peer did not take it in Zenoh's time: the threads end with the program
            session.close()
    finally:  # also after a panic inside Zenoh
        with suppress(RuntimeError):
            loop.call_soon_threadsafe(closed.set)


def _open(settings: RosSettings, rights: WireRights) -> object:
    if settings.cert_file is not None:
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        what, option = "[ros] certificate", "key_file"
        load_certificate(context, settings.cert_file, settings.key_file, what=what, key_option=option)
    with TemporaryDirectory() as folder:  # Zenoh takes passwords from a file alone, and reads it now
        users = Path(folder, "users")
        users.touch(0o600)
        users.write_text(rights.dictionary())
        return zenoh.open(zenoh.Config.from_json5(json.dumps(_config(settings, rights, str(users)))))


def _config(settings: RosSettings, rights: WireRights, users: str) -> dict[str, object]:
    """Return the configuration of Zenoh: always a router, as to a peer others may send past the rules."""
    listens = bool(settings.listen) and not settings.connect
    user, password = rights.login or (None, None)
    files = {"root_ca_certificate": settings.ca}
    if listens:
        files |= {"listen_certificate": settings.cert_file, "listen_private_key": settings.key_file}
    login = {"user": user, "password": password and password.get_secret_value()}
    return {
        "mode": "router",
        "connect": {"endpoints": settings.connect, "timeout_ms": -1, "exit_on_failure": False, "retry": _RETRY},
        "listen": {"endpoints": [settings.listen] if listens else []},
        "scouting": {"multicast": {"enabled": False}, "gossip": {"enabled": False}},
        "timestamping": {"enabled": True},
        "transport": {
            "shared_memory": {"enabled": False},  # 20 MB for each program on this computer that sends long messages
            "link": {"tls": {key: file and str(file) for key, file in files.items()}},
            "auth": {"usrpwd": {"dictionary_file": users} if listens else login},
        },
        "access_control": rights.access_control(),
    }
