"""Notifications of apps to people: the table ``[notify]``."""

from __future__ import annotations

import json
import logging
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from datetime import datetime, tzinfo
from functools import partial
from typing import TYPE_CHECKING, Annotated, Final, TypeAlias, final

import anyio
from pydantic import BaseModel, ConfigDict, Field, SecretStr

from homebot.config import AlertKey, Urgency
from homebot.devices.command_sender import GatewayOutput
from homebot.devices.gateway_messages import RawCommand
from homebot.log import LogLimit, more_like_this
from homebot.support.bounded_map import BoundedMap
from homebot.support.bounded_threads import BoundedThreads
from homebot.support.limits import RateLimit

if TYPE_CHECKING:
    from homebot.graph import Node

SENT: Final = "app.notified"
NOT_SENT: Final = "app.not_notified"
DROPPED: Final = "app.notification_dropped"

_TOPIC: Final = "homebot/notifications"
_AT_ONCE: Final = 10
_PER_SECOND: Final = 0.1
_MAX_APPS: Final = 1000
_LOG_ALONE: Final = "only in the log; the table [notify] of the configuration sends notifications to people"
_MAX_CHARACTERS: Final = 4000
_MAX_TITLE: Final = 200
_APPRISE_LIMIT: Final = 30.0
_MAX_THREADS: Final = 4


_Urls: TypeAlias = Annotated[tuple[SecretStr, ...], Field(max_length=50)]


class NotifySettings(BaseModel):
    """The keys of ``[notify]``.

    Attributes:
        gateway: The gateway for MQTT that publishes notifications.
        topic: Its topic; by default ``homebot/notifications``, or none if there are *urls*.
        urls: Addresses of services for `apprise`; they contain passwords.
        urls_by: Those of a kind of alert or of an urgency, in place of *urls*; the kind decides first.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True)

    gateway: str = "mqtt"
    topic: str | None = Field(default=None, max_length=1000, pattern=r"^[^+#\x00]*$")
    urls: _Urls = ()
    urls_by: Mapping[AlertKey | Urgency, _Urls] = Field(default_factory=dict)

    @property
    def address(self) -> str:
        """The topic; empty for none."""
        return ("" if self.has_urls else _TOPIC) if self.topic is None else self.topic

    @property
    def has_urls(self) -> bool:
        """True if some notifications go to services."""
        return any((self.urls, *self.urls_by.values()))

    def urls_for(self, urgency: Urgency, kind: str) -> tuple[tuple[str, SecretStr], ...]:
        """Return the addresses for notifications of an alert's *kind*, if any, and of *urgency*, by their keys."""
        rows = (
            (f"urls_by.{key}", urls)
            for wanted in (kind, urgency)
            for key, urls in self.urls_by.items()
            if key == wanted
        )
        name, urls = next(rows, ("urls", self.urls))
        return tuple((f"notify.{name}[{number}]", url) for number, url in enumerate(urls))


@final
@dataclass(frozen=True, slots=True)
class Notification:
    """A message of an app to people.

    Attributes:
        time: The date and time in the home's zone.
        kind: That of an alert; empty for others.
    """

    message: str
    title: str
    app: str
    time: datetime
    urgency: Urgency = "normal"
    kind: str = ""

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
        self._settings: NotifySettings | None = None
        self._output: GatewayOutput | None = None
        self._outputs: dict[str, GatewayOutput] = {}
        self._limits: BoundedMap[str, RateLimit] = BoundedMap(_MAX_APPS)
        self._lines = LogLimit(self._clock)
        self._threads = BoundedThreads(_MAX_THREADS, "notification")
        self.recent: deque[Notification] = deque(maxlen=100)
        self.dropped = self.failed = 0
        self.trouble = ""
        self.send_by(settings)

    def send_by(self, settings: NotifySettings | None) -> None:
        """Send by *settings* from now on."""
        if settings != self._settings:
            self.trouble = ""
        self._settings = settings
        gateway = settings.gateway if settings and settings.address else ""
        if gateway and gateway not in self._outputs:
            self._outputs[gateway] = GatewayOutput(self._node, gateway)
        self._output = self._outputs.get(gateway)

    async def send(
        self, message: str, title: str, app: str, zone: tzinfo, urgency: Urgency = "normal", kind: str = ""
    ) -> bool:
        """Send a message of *app*, truncated to 4,000 characters; return whether a service accepted it."""
        time = datetime.fromtimestamp(self._clock.now(), zone)
        notification = Notification(str(message)[:_MAX_CHARACTERS], str(title)[:_MAX_TITLE], app, time, urgency, kind)
        limit = self._limits[app] = self._limits.get(app) or RateLimit(_PER_SECOND, _AT_ONCE)
        if not limit.admits(self._clock.monotonic()):
            self.dropped += 1
            if (held_back := self._lines.allows(app)) is not None:
                text = f"{app} notifies too often, at most once in 10 s: dropped{more_like_this(held_back)}"
                self._node.log.warning(DROPPED, message=f"{text}: {notification.text[:_MAX_TITLE]}", app=app)
            return False
        hint = "" if self._settings or self.recent else f" ({_LOG_ALONE})"
        self.recent.append(notification)
        self._node.log.info(SENT, message=f"{app} notifies: {notification.text}{hint}", app=app)
        problems = [*await self._publish(notification), *await self._push(notification)]
        self.trouble = "; ".join(dict.fromkeys(problems))
        if problems:
            self.failed += 1
            self._node.log.error(NOT_SENT, message=f"a notification of {app} was not sent: {self.trouble}", app=app)
        if self._settings is None:
            return False
        ways = bool(self._output) + len(self._settings.urls_for(urgency, kind))
        return len(problems) < ways or not ways  # for some kinds the owner wants none

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
        urls = () if self._settings is None else self._settings.urls_for(notification.urgency, notification.kind)
        if not urls:
            return ()
        send = partial(_push, urls, notification.message, notification.title, notification.urgency)
        with anyio.move_on_after(_APPRISE_LIMIT):
            return await self._threads.run(send)
        return [f"apprise did not answer within {_APPRISE_LIMIT:g} s"] * len(urls)


_PRIORITIES: Final[Mapping[Urgency, Sequence[str]]] = {
    "high": ("max", "emergency", "critical", "urgent", "P1", "high"),
    "normal": (),
    "low": ("low", "silent", "P5", "info"),
}
"""Words of services for the highest priority and a low one; a normal message has that of its address."""


def _push(urls: Sequence[tuple[str, SecretStr]], message: str, title: str, urgency: Urgency) -> list[str]:
    """Send a message to each of *urls*, which have names, with apprise, blocking; return the problems.

    The addresses contain passwords, so neither problems nor log lines show them.
    """
    import apprise  # noqa: PLC0415 - an extra, and it takes a second

    logger = logging.getLogger("apprise")
    logger.propagate, logger.handlers = False, [logging.NullHandler()]  # its lines contain addresses
    problems = []
    kind = apprise.NotifyType.FAILURE if urgency == "high" else apprise.NotifyType.INFO
    for name, url in urls:
        try:
            address = url.get_secret_value()
            service = apprise.Apprise.instantiate(address)
            if service is not None and (priority := _priority(service.template_args, urgency)):
                known = apprise.plugins.url_to_dict(address)  # type: ignore[no-untyped-call]
                service = apprise.Apprise.instantiate(known | {"priority": priority})
            if service is None:
                problems.append(f"{name} is not an address that apprise knows")
            elif not service.notify(body=message, title=title, notify_type=kind):
                problems.append(f"{service.service_name} ({name}) did not answer, or refused it")
        except Exception as exc:  # noqa: BLE001 - a plug-in of apprise; its text may have the address
            problems.append(f"{name} failed ({type(exc).__name__})")
    return problems


def _priority(arguments: Mapping[str, Mapping[str, object]], urgency: Urgency) -> str:
    """Return the priority for *urgency* of a service with these *arguments*; empty if it has none."""
    known = arguments.get("priority", {}).get("values")
    if isinstance(known, tuple) and known and all(isinstance(item, int) for item in known):
        return {"high": str(max(known)), "low": str(min(known)), "normal": ""}[urgency]
    words = known.values() if isinstance(known, Mapping) else known if isinstance(known, tuple) else ()
    return next((word for word in _PRIORITIES[urgency] if word in words), "")
