"""Notifications of apps to people: the table ``[notify]``."""

from __future__ import annotations

import json
import logging
from collections import deque
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, tzinfo
from functools import partial
from typing import TYPE_CHECKING, Final, final

import anyio
from anyio import to_thread
from pydantic import BaseModel, ConfigDict, Field, SecretStr

from homebot.devices.command_sender import GatewayOutput
from homebot.devices.gateway_messages import RawCommand
from homebot.log import LogLimit, more_like_this
from homebot.support.bounded_map import BoundedMap
from homebot.support.rate_limit import RateLimit

if TYPE_CHECKING:
    from homebot.graph import Node

__all__ = ["Notification", "Notifier", "NotifySettings"]

SENT: Final = "app.notified"
NOT_SENT: Final = "app.not_notified"
DROPPED: Final = "app.notification_dropped"

_TOPIC: Final = "homebot/notifications"
_AT_ONCE: Final = 10
_PER_SECOND: Final = 0.1
_MOST_APPS: Final = 1000
_LOG_ALONE: Final = "only in the log; the table [notify] of the configuration sends notifications to people"
_LONGEST: Final = 4000
_LONGEST_TITLE: Final = 200
_APPRISE_LIMIT: Final = 30.0
_MOST_THREADS: Final = 4


class NotifySettings(BaseModel):
    """The keys of ``[notify]``.

    Attributes:
        gateway: The gateway for MQTT that publishes notifications.
        topic: Its topic; by default ``homebot/notifications``, or none if there are *urls*.
        urls: Addresses of services for `apprise`; they contain passwords.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    gateway: str = "mqtt"
    topic: str | None = Field(default=None, max_length=1000, pattern=r"^[^+#\x00]*$")
    urls: tuple[SecretStr, ...] = Field(default=(), max_length=50)

    @property
    def address(self) -> str:
        """The topic; empty for none."""
        return ("" if self.urls else _TOPIC) if self.topic is None else self.topic


@final
@dataclass(frozen=True, slots=True)
class Notification:
    """A message of an app to people.

    Attributes:
        time: The date and time in the home's zone.
    """

    message: str
    title: str
    app: str
    time: datetime

    @property
    def text(self) -> str:
        """The title and the message in one line."""
        return f"{self.title}: {self.message}" if self.title else self.message


@final
class Notifier:
    """Sends notifications: a burst of ten for each app, then one in 10 s; others are dropped and counted.

    Args:
        settings: The table; without it they are logged alone.

    Attributes:
        failed: Number of notifications that a service did not accept.
        trouble: The reason why the last one was not sent; empty if it was.
    """

    def __init__(self, node: Node, settings: NotifySettings | None) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._settings = settings
        self._limits: BoundedMap[str, RateLimit] = BoundedMap(_MOST_APPS)
        self._lines = LogLimit(self._clock)
        self._output = GatewayOutput(node, settings.gateway) if settings and settings.address else None
        self._threads = anyio.CapacityLimiter(_MOST_THREADS)
        self.recent: deque[Notification] = deque(maxlen=100)
        self.dropped = self.failed = 0
        self.trouble = ""

    async def send(self, message: str, title: str, app: str, zone: tzinfo) -> bool:
        """Send a message of *app*, truncated to 4,000 characters; return whether a service accepted it."""
        time = datetime.fromtimestamp(self._clock.now(), zone)
        one = Notification(str(message)[:_LONGEST], str(title)[:_LONGEST_TITLE], app, time)
        limit = self._limits[app] = self._limits.get(app) or RateLimit(_PER_SECOND, _AT_ONCE)
        if not limit.admits(self._clock.monotonic()):
            self.dropped += 1
            if (held_back := self._lines.allows(app)) is not None:
                text = f"{app} notifies too often, at most once in 10 s: dropped{more_like_this(held_back)}"
                self._node.log.warning(DROPPED, message=f"{text}: {one.text[:_LONGEST_TITLE]}", app=app)
            return False
        hint = "" if self._settings or self.recent else f" ({_LOG_ALONE})"
        self.recent.append(one)
        self._node.log.info(SENT, message=f"{app} notifies: {one.text}{hint}", app=app)
        problems = [*await self._publish(one), *await self._push(one)]
        self.trouble = "; ".join(dict.fromkeys(problems))
        if problems:
            self.failed += 1
            self._node.log.error(NOT_SENT, message=f"a notification of {app} was not sent: {self.trouble}", app=app)
        return self._settings is not None and len(problems) < bool(self._output) + len(self._settings.urls)

    async def _publish(self, notification: Notification) -> tuple[str, ...]:
        if self._output is None or self._settings is None:
            return ()
        if problem := self._output.refusal() or self._output.unavailable:
            return (f"{self._settings.gateway}: {problem}",)
        payload = asdict(notification) | {"time": notification.time.isoformat(timespec="seconds")}
        text = json.dumps(payload, ensure_ascii=False)
        await self._output.out.send(RawCommand(address=self._settings.address, payload=text, issuer=notification.app))
        is_running = self._output.out.reaches(self._output.node)
        return () if is_running else (f"gateway {self._settings.gateway} is not running",)

    async def _push(self, notification: Notification) -> Sequence[str]:
        if self._settings is None or not self._settings.urls:
            return ()
        send = partial(_push, self._settings.urls, notification.message, notification.title)
        with anyio.move_on_after(_APPRISE_LIMIT):
            return await to_thread.run_sync(send, limiter=self._threads, abandon_on_cancel=True)
        return [f"apprise did not answer within {_APPRISE_LIMIT:g} s"] * len(self._settings.urls)


def _push(urls: tuple[SecretStr, ...], message: str, title: str) -> list[str]:
    """Send a message to each of *urls* with apprise, blocking; return the problems.

    The addresses contain passwords, so neither problems nor log lines show them.
    """
    import apprise  # noqa: PLC0415 - an extra, and it takes a second

    logger = logging.getLogger("apprise")
    logger.propagate, logger.handlers = False, [logging.NullHandler()]  # its lines contain addresses
    problems = []
    for number, url in enumerate(urls):
        name = f"notify.urls[{number}]"
        try:
            service = apprise.Apprise.instantiate(url.get_secret_value())
            if service is None:
                problems.append(f"{name} is not an address that apprise knows")
            elif not service.notify(body=message, title=title):
                problems.append(f"{service.service_name} ({name}) did not answer, or refused it")
        except Exception as exc:  # noqa: BLE001 - a plug-in of apprise; its text may have the address
            problems.append(f"{name} failed ({type(exc).__name__})")
    return problems
