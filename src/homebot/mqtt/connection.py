"""An MQTT connection that is kept up: it connects, subscribes, announces itself, and reconnects when the link breaks.

It is independent of any library and drives a `MqttClient`. One supervising task owns the link. `receive` returns the
messages of all links; subscriptions are made again on each; publishing without a link fails at once, because a command
that fires minutes late is worse than one that fails.
"""

import enum
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from operator import attrgetter
from random import Random
from types import TracebackType
from typing import Final, NamedTuple, Self, final

import anyio
from anyio.abc import TaskGroup
from anyio.lowlevel import checkpoint

from homebot.clock import Clock, LoopClock
from homebot.errors import ClosedError, HomebotError, LinkError, RefusedError, UsageError
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.message import MqttMessage
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.packets import Will
from homebot.mqtt.subscriptions import SubscriptionSet
from homebot.mqtt.topics import validate_filter
from homebot.support.backoff import LINK_BACKOFF, REFUSED_BACKOFF, Backoff, BackoffCounter
from homebot.support.logger import get_logger

ONLINE: Final = b"online"
OFFLINE: Final = b"offline"
"""The status of a client on its broker."""

_OFFLINE_WITHIN = 1.0
"""Seconds for the last "offline" at a clean close; otherwise the broker publishes it as the will."""

_STABLE = 5.0
"""A link that lasted fewer seconds counts as a failed attempt, so that a broker that disconnects us right after the
login is not asked in a tight loop."""

_FILTER = attrgetter("filter")

_log = get_logger()


@enum.unique
class LinkPhase(enum.StrEnum):
    """The phase of the supervisor: messages are received from SUBSCRIBING on, all that is wanted in CONNECTED."""

    CONNECTING = "connecting"
    SUBSCRIBING = "subscribing"
    CONNECTED = "connected"
    WAITING = "waiting"
    REFUSED = "refused"
    CLOSED = "closed"


class ConnectionState(NamedTuple):
    """A phase and its cause.

    Attributes:
        phase: WAITING waits for the next attempt after the link failed; so does REFUSED, but the broker refused and a
            person has to fix something.
        reason: The failure in words, without secrets; empty if all is well.
        retry_in: Seconds from the beginning of the phase to the next attempt; None if there is none.
    """

    phase: LinkPhase
    reason: str = ""
    retry_in: float | None = None


@final
class MqttConnection:
    """A self-healing connection to one broker; use it as ``async with`` inside a running event loop.

    Entering starts the supervisor without waiting for the broker (`wait_connected` does). Leaving publishes "offline",
    then disconnects; after that it may be entered again. Changes of the link are states, logged at debug level only, so
    that the owner can choose a level for them.

    Args:
        status_topic: Retained "online" and "offline" are published there, the latter also by the broker as this
            client's will; by default ``homebot/<client id>/status``, with "+" and "#" of the client id made "_". None
            announces nothing.
        is_paced: Whether retained messages are requested gradually; see `SubscriptionSet`. Some brokers drop messages
            that a client reads too slowly; the embedded one waits.

    Attributes:
        ack: Acknowledges messages to the broker; see `Receiver.ack`.
        publish: Publishes; see `MqttClient.publish`. Raises LinkError at once while the link is down.
        url: The broker's address, without user and password.
    """

    def __init__(
        self,
        options: MqttOptions,
        make_client: Callable[[MqttOptions], MqttClient],
        *,
        status_topic: str | None = "",
        clock: Clock | None = None,
        random: Random | None = None,
        link_backoff: Backoff = LINK_BACKOFF,
        refused_backoff: Backoff = REFUSED_BACKOFF,
        is_paced: bool = True,
    ) -> None:
        if status_topic == "":
            status_topic = f"homebot/{options.client_id.replace('+', '_').replace('#', '_')}/status"
        if status_topic is not None and options.will is None:
            options = replace(options, will=Will(status_topic, OFFLINE, qos=1, retain=True))
        self.url = options.url
        self.status_topic = status_topic
        self._client = make_client(options)
        self.ack, self.publish = self._client.ack, self._client.publish
        self.counters = self._client.counters
        self._clock = LoopClock() if clock is None else clock
        self._retries = BackoffCounter(self._clock, random or Random())  # noqa: S311 - jitter is no secret
        self._link_backoff = link_backoff
        self._refused_backoff = refused_backoff
        self._standing = SubscriptionSet(self._client, is_paced=is_paced)
        self.state = ConnectionState(LinkPhase.CLOSED)
        self._changed = anyio.Event()
        self._tasks: TaskGroup | None = None
        self._protocol = ""

    @property
    def refused(self) -> Mapping[str, str]:
        """The subscriptions refused on the current link: the reasons by filter, a copy.

        Complete when the phase becomes CONNECTED. The next link requests them again; whether the connection is of use
        without them is up to its owner.
        """
        return self._standing.refused

    @property
    def expires_messages(self) -> bool:
        """True if the broker of the last link drops expired messages (MQTT 5)."""
        return self._protocol == "5"

    async def states(self) -> AsyncIterator[ConnectionState]:
        """Yield the current and each later state, until CLOSED; a slow reader misses some, never the latest."""
        seen: ConnectionState | None = None
        while True:
            if self.state is seen:
                await self._changed.wait()
                continue
            seen = self.state
            yield seen
            if seen.phase is LinkPhase.CLOSED:
                return

    async def wait_connected(self) -> None:
        """Wait until the link is up and its subscriptions are made.

        Raises:
            RefusedError: The broker refused; the supervisor keeps trying, slowly.
            ClosedError: The connection is closed.
        """
        while self.state.phase is not LinkPhase.CONNECTED:
            if self.state.phase is LinkPhase.REFUSED:
                raise RefusedError(f"the connection to {self.url}", self.state.reason)
            if self.state.phase is LinkPhase.CLOSED:
                raise ClosedError(f"the connection to {self.url} is closed")
            await self._changed.wait()

    async def require_link(self) -> None:
        """Return once an answer would be received: at once where a resumed session has all subscriptions.

        Raises:
            LinkError: There is no link, or it was lost before they were made.
        """
        while self.state.phase is not LinkPhase.CONNECTED:
            if self.state.phase is not LinkPhase.SUBSCRIBING:
                await checkpoint()  # as in publish
                raise LinkError(f"{self.url}: not connected")
            if self._standing.is_complete:
                return
            await self._changed.wait()

    async def subscribe(self, *subscriptions: MqttSubscription, every_link: bool = False) -> None:
        """Subscribe now and on every later link; a second subscription to the same filter replaces the first.

        Without a link they are only remembered. Refused filters are in `refused`, and are requested again on every
        later link until `unsubscribe`.

        Args:
            every_link: Whether to subscribe again even if a resumed session still has them, to receive retained
                messages. Otherwise those that changed at QoS 0 while the link was down are lost.

        Raises:
            InvalidNameError: A filter is not a topic filter; nothing is remembered.
            RefusedError: At least one was refused; the message names them. The others are valid.
        """
        for subscription in subscriptions:
            validate_filter(subscription.filter)
        self._standing.want(subscriptions, every_link=every_link)
        try:
            refused = await self._standing.make(map(_FILTER, subscriptions))
        except LinkError:
            return
        if refused:
            raise _join(refused)

    async def unsubscribe(self, *filters: str) -> None:
        """Remove subscriptions, now and for every later link."""
        self._standing.drop(filters)
        with suppress(LinkError):
            await self._standing.unsubscribe_from(filters)

    async def receive(self) -> list[MqttMessage]:
        """Return all received messages of any link in order; wait for the first.

        Raises:
            ClosedError: The connection is closed and all messages are read.
        """
        while True:
            try:
                return await self._client.receive()
            except LinkError:
                changed = self._changed
                if self.state.phase is LinkPhase.CLOSED:
                    raise ClosedError(f"the connection to {self.url} is closed") from None
                await changed.wait()

    async def announce_online(self) -> None:
        """Publish "online" again, as after another client with the same status topic has left; needs a link."""
        with suppress(LinkError):  # the next link publishes it
            await self._publish_status(ONLINE)

    def drop(self) -> None:
        """Cut the link without a DISCONNECT, as a power failure does, and reconnect as after any loss."""
        self._client.drop()

    async def __aenter__(self) -> Self:
        if self._tasks is not None:
            raise UsageError(f"the connection to {self.url} is already open")
        self._tasks = anyio.create_task_group()
        await self._tasks.__aenter__()
        self._enter(LinkPhase.CONNECTING)
        self._tasks.start_soon(self._supervise)
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> bool | None:
        tasks, self._tasks = self._tasks, None
        if tasks is None:
            return None
        tasks.cancel_scope.cancel()
        # An error of the caller's block passes as it is, not wrapped into a group; only a cancellation has to
        # be shown to the task group, which knows whether it is its own.
        if isinstance(error, anyio.get_cancelled_exc_class()):
            return await tasks.__aexit__(kind, error, trace)
        await tasks.__aexit__(None, None, None)
        return None

    async def _supervise(self) -> None:
        try:
            while True:
                self._enter(LinkPhase.CONNECTING, self.state.reason)
                delay = await self._try_once()
                if delay > 0:
                    await anyio.sleep(delay)
        finally:
            self._enter(LinkPhase.CLOSED)

    async def _try_once(self) -> float:
        """Run one link from start to end; return the seconds to wait before the next."""
        up_since: float | None = None
        reason: HomebotError
        try:
            async with self._client.connected() as session:
                try:
                    self._standing.begin_link(resumed=session.resumed)
                    self._enter(LinkPhase.SUBSCRIBING)
                    if refused := await self._standing.make_all():
                        _log.debug(
                            "mqtt.subscriptions_refused",
                            message=f"{self.url}: {_join(refused)}",
                            broker=self.url,
                            filters=list(refused),
                        )
                    await self._publish_status(ONLINE)
                    up_since = self._clock.monotonic()
                    self._protocol = session.protocol
                    self._enter(LinkPhase.CONNECTED)
                    _log.debug(
                        "mqtt.connected",
                        message=f"connected to {self.url} with MQTT {session.protocol}",
                        broker=self.url,
                        protocol=session.protocol,
                        resumed=session.resumed,
                    )
                    reason = await self._client.wait_lost()
                except anyio.get_cancelled_exc_class():
                    with anyio.CancelScope(shield=True), anyio.move_on_after(_OFFLINE_WITHIN), suppress(LinkError):
                        await self._publish_status(OFFLINE)
                    raise
        except (LinkError, RefusedError, UsageError) as error:  # UsageError: a certificate file
            reason = error
        return self._plan(reason, up_since)

    async def _publish_status(self, status: bytes) -> None:
        """Publish *status*; a refusal is only logged, because everything else still works."""
        if self.status_topic is None:
            return
        try:
            await self.publish(self.status_topic, status, qos=1, retain=True)
        except RefusedError as error:
            _log.warning(
                "mqtt.status_refused",
                message=f"{self.url}: cannot publish the status of homebot: {error}",
                broker=self.url,
                reason=error.reason,
            )

    def _plan(self, reason: HomebotError, up_since: float | None) -> float:
        refused = not isinstance(reason, LinkError)
        if up_since is not None and self._clock.monotonic() - up_since >= _STABLE:
            self._retries.succeed()
        was_up = up_since is not None
        is_first_loss = was_up and not self._retries.has_failed and not refused
        pause = self._retries.fail(self._refused_backoff if refused else self._link_backoff)
        delay = 0.0 if is_first_loss else pause
        phase, event = LinkPhase.WAITING, "mqtt.link_lost" if was_up else "mqtt.unreachable"
        if refused:
            phase, event = LinkPhase.REFUSED, "mqtt.refused"
        self._enter(phase, str(reason), delay)
        _log.debug(
            event,
            message=f"{reason}; next try {'at once' if delay == 0 else f'in {delay:.1f} s'}",
            broker=self.url,
            reason=str(reason),
            retry_in=round(delay, 2),
        )
        return delay

    def _enter(self, phase: LinkPhase, reason: str = "", retry_in: float | None = None) -> None:
        if phase is not LinkPhase.CONNECTED:
            self._standing.link_ended()
        self.state = ConnectionState(phase, reason, retry_in)
        self._changed.set()
        self._changed = anyio.Event()


def _join(refused: dict[str, RefusedError]) -> RefusedError:
    names = ", ".join(repr(name) for name in refused)
    first = next(iter(refused.values()))
    return RefusedError(f"the subscription to {names}", first.reason, first.code)
