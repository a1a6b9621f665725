"""A house in a test: the embedded broker, a homebot with the app under test, and the side of the devices."""

from __future__ import annotations

from collections import deque
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import replace
from random import Random
from typing import TYPE_CHECKING, Final

import anyio

from homebot.config import Config, Table, parse_config, parse_settings
from homebot.devices.house_view import HouseView
from homebot.errors import ClosedError, InvalidNameError, PluginError, UsageError
from homebot.feature import plugin_tables
from homebot.gateways.mqtt import MqttGateway
from homebot.gateways.mqtt.settings import EMBEDDED, MqttGatewaySettings, embedded_ports
from homebot.graph import Node
from homebot.mqtt.broker import Broker
from homebot.mqtt.client import MqttClient, MqttSubscription
from homebot.mqtt.client.native import NativeClient
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.options import MqttOptions
from homebot.mqtt.topics import validate_topic
from homebot.plugins import add_app, load_plugin
from homebot.runtime import Runtime
from homebot.support.addresses import is_loopback
from homebot.support.bounded_map import BoundedMap
from homebot.testing.contexts import in_background, plain_logs
from homebot.testing.expectation import Expectation
from homebot.units import parse_duration

if TYPE_CHECKING:
    from homebot.apps.notifier import Notification
    from homebot.testing.event_log import EventLog

GATEWAYS = "homebot.gateways"

LOGIN: Final = frozenset({"user", "password_file", "password_env", "ca_file", "cert_file", "key_file", "client_id"})
"""Keys of a gateway's table that describe a broker, which is replaced by the test's."""


def house_config(
    apps: Sequence[str], root: str, url: str, given: Config | Mapping[str, object] | None = None
) -> Config:
    """Return *given* with *apps*, adapted for a test.

    An MQTT gateway without a broker on this computer gets the one at *url*, and acts: a test never touches a real
    house, and notifications do not reach people. Its root is *root* unless it has one; if there are no gateways but
    that of people, it is added. The door gets a free port, and the home the zone UTC, unless given.

    Args:
        apps: Plug-in names or ``module:Class``; added last, unless *given* has a table for them.
        given: A configuration, or tables as in ``homebot.toml``.

    Raises:
        UsageError: The address of a broker, or a table, is invalid.
    """
    given = given if isinstance(given, Config) else parse_config(given or {}, "config")
    gateways = given.gateways if given.gateways.keys() - {*plugin_tables().values()} else {"mqtt": {}, **given.gateways}
    planned = dict(given.apps)
    for app in apps:
        add_app(planned, app)
    return given.model_copy(
        update={
            "gateways": {name: _on_test_broker(name, table, root, url) for name, table in gateways.items()},
            "apps": planned,
            "door": {"port": 0} | given.door,
            "notify": given.notify
            and {key: value for key, value in given.notify.items() if not key.startswith("urls")},
            "home": given.home if given.home.zone else given.home.model_copy(update={"zone": "UTC"}),
        }
    )


def mqtt_gateway_of(config: Config) -> MqttGatewaySettings | None:
    """Return the settings of the first MQTT gateway in *config*.

    Raises:
        ConfigError: Its table is invalid.
    """
    for name, table in config.gateways.items():
        if _is_for_mqtt(name, table):
            return parse_settings(MqttGatewaySettings, table, config.source, f"gateways.{name}", config.folder)
    return None


def _on_test_broker(name: str, table: Table, root: str, url: str) -> Table:
    if not _is_for_mqtt(name, table):
        return table
    table = {"root": root} | table
    if _is_here(table.get("url", EMBEDDED)):
        return table
    kept = {key: value for key, value in table.items() if key not in LOGIN}
    return {"act": True} | kept | {"url": url}


def _is_here(url: object) -> bool:
    """Return whether *url* is a broker that a test may use; invalid types are refused later, with their key."""
    return not isinstance(url, str) or (embedded_ports(url) is None and is_loopback(MqttOptions.from_url(url).host))


def _is_for_mqtt(name: str, table: Table) -> bool:
    try:
        kind = load_plugin(GATEWAYS, str(table.get("class", name)))
    except PluginError:  # the runtime reports it, with its key
        return False
    return issubclass(kind, MqttGateway)


DEFAULT_WAIT = 30.0
"""Seconds; milliseconds on an idle computer, but one that runs tests may be slow or busy."""

EVERYTHING = MqttSubscription("#", qos=1, no_local=True)
"""The subscription of a test: everything except its own messages."""

KEPT = 1000
"""Most unread payloads of one topic; the oldest is dropped first."""

MAX_TOPICS = 10_000
"""Most topics with unread payloads; the oldest is dropped first."""


_SHOWN = 10


class TestHouse:
    """A running homebot with its own broker, on which a test plays the devices.

    Attributes:
        broker_url: The address of its broker, as ``mqtt://host:port``.
    """

    __test__ = False  # not a test class in spite of its name

    def __init__(
        self,
        runtime: Runtime,
        field: MqttConnection,
        options: MqttOptions,
        make_client: Callable[[MqttOptions], MqttClient],
    ) -> None:
        self.runtime = runtime
        self.broker_url = options.url
        self._options = options
        self._make_client = make_client
        self._log: EventLog | None = None
        self._field = field
        self._received: BoundedMap[str, deque[str]] = BoundedMap(MAX_TOPICS)
        self._came = anyio.Event()

    @property
    def crashed(self) -> tuple[str, ...]:
        """The parts of the runtime that crashed or had a failing callback, each once, sorted."""
        return tuple(sorted(self.failures))

    @property
    def failures(self) -> Mapping[str, str]:
        """The last failure of each part of the runtime that crashed or had a failing callback."""
        failed = {
            failure.node.lstrip("/"): f"the {failure.callback} failed: {failure.last}"
            for failure in self.runtime.graph.failures
        }
        return failed | {name: f"it crashed: {crash.last}" for name, crash in self.runtime.supervisor.crashes.items()}

    @property
    def notifications(self) -> tuple[Notification, ...]:
        """The last hundred notifications of apps, each with ``message``, ``title``, ``app`` and ``time``."""
        return tuple(self.runtime.app_host.notifier.recent)

    @property
    def log(self) -> EventLog:
        """The log of events, kept by the pytest fixtures and by :meth:`EventLog.of`.

        Raises:
            UsageError: No log is kept of this house.
        """
        if self._log is None:
            raise UsageError("this house has no event log: `async with EventLog.of(house) as log` does")
        return self._log

    @log.setter
    def log(self, log: EventLog) -> None:
        self._log = log

    def client(self, client_id: str) -> MqttConnection:
        """Return another client of the broker, which connects when entered with ``async with``."""
        return MqttConnection(
            replace(self._options, client_id=client_id),
            self._make_client,
            status_topic=None,
            clock=self.runtime.graph.clock,
            random=Random(0),  # noqa: S311 - a test has no secrets
        )

    async def says(self, topic: str, payload: str) -> None:
        """Publish *payload* on *topic* like a device; return when the broker has acknowledged it."""
        await self._field.publish(topic, payload.encode(), qos=1)

    async def hears(self, topic: str, within: str | float = DEFAULT_WAIT) -> str:
        """Return the next payload that homebot or a device, but not the test, publishes on *topic*.

        Args:
            within: The longest wait: such as ``"5m"``, or seconds.

        Raises:
            TimeoutError: Nothing arrived in time; the message lists other received topics and crashed apps.
            UsageError: *topic* or *within* is invalid.
        """
        __tracebackhide__ = True
        seconds = parse_duration(within, "within")
        try:
            validate_topic(topic)
        except InvalidNameError as exc:
            raise UsageError(f"hears({topic!r}): {exc}; give a topic without wildcards") from None
        with anyio.move_on_after(seconds):
            while not self._received.get(topic):
                await self._came.wait()
        received = self._received.get(topic)
        if not received:
            raise TimeoutError(self._timeout_text(topic, seconds))
        return received.popleft()

    async def becomes(self, device: str, *, within: str | float = DEFAULT_WAIT, **values: object) -> None:
        """Return once *device* has *values* in the directory.

        Args:
            device: Its id, or one of its names.
            within: The longest time: such as ``"5m"``, or seconds.
            values: Values by properties of its handle, for example ``on=False`` or ``level=40``.

        Raises:
            AssertionError: It has other values when the time is over; the message says which.
        """
        __tracebackhide__ = True
        async with Node(self.runtime.graph, "expectation") as node:
            await Expectation(HouseView.of(node), device, values).wait(within)

    async def reload(self, app: str) -> None:
        """Stop *app* and start it from its file, like ``homebot app reload``; its store is kept.

        Raises:
            UsageError: There is no such app, or the new one cannot be loaded or crashes at once, so that the old one
                runs.
        """
        __tracebackhide__ = True
        await self.runtime.app_manager.reload(app)

    async def misspelt_names(self) -> tuple[str, ...]:
        """Return the queries of apps in which a name is misspelt, with the name that was probably meant."""
        apps = tuple(self.runtime.app_host.running.items())
        mistakes = {name: await HouseView.of(app.node).names.mistakes() for name, app in apps}
        mistakes |= self.runtime.app_host.misspelt_at_end
        return tuple(f"{name}: {mistake}" for name in mistakes for mistake in mistakes[name])

    async def listen(self) -> None:
        """Receive homebot's messages until cancelled."""
        while True:
            try:
                messages = await self._field.receive()
            except ClosedError:
                return
            for message in messages:
                if message.topic not in self._received:
                    self._received[message.topic] = deque(maxlen=KEPT)
                self._received[message.topic].append(message.payload.decode(errors="replace"))
            self._field.ack(messages)
            self._came.set()
            self._came = anyio.Event()

    def _timeout_text(self, topic: str, within: float) -> str:
        """Describe the messages on other topics, those from homebot to devices first, without its own status."""
        received = [name for name, payloads in self._received.items() if payloads and not name.endswith("/mqtt/status")]
        names = sorted(received, key=lambda name: not name.endswith("/in"))
        elsewhere = {name: list(self._received[name])[-_SHOWN:] for name in names[:_SHOWN]}
        return (
            f"nothing came on {topic} within {within:g} s; "
            f"received elsewhere: {elsewhere or 'nothing'}; crashed: {', '.join(self.crashed) or 'nothing'}"
        )


@asynccontextmanager
async def house_of(
    *apps: str, root: str = "home425", config: Config | Mapping[str, object] | None = None
) -> AsyncIterator[TestHouse]:
    """Run *apps*, plug-in names or ``module:Class``, in a homebot with its own broker.

    Devices that do not announce themselves publish on ``<root>/SERVICE_TYPE/DEVICE_ID/out`` and take commands on
    ``…/in``.

    Args:
        config: Further configuration, as in ``homebot.toml``; a broker on another computer is replaced by the test's,
            and free ports are used unless given.

    Raises:
        UsageError: The configuration is invalid.
    """
    with plain_logs():
        async with Broker() as broker:
            made = house_config(apps, root, broker.url, config)
            gateway = mqtt_gateway_of(made)
            own = MqttOptions.from_url(broker.url)
            options = own if gateway is None else replace(gateway.options(), client_id=own.client_id)
            runtime = Runtime(made, trusts_apps=True)
            for mistake in runtime.app_host.left_out.values():
                raise mistake
            async with (
                runtime,
                MqttConnection(options, NativeClient, status_topic=None) as field,
            ):
                await field.subscribe(EVERYTHING)
                await field.wait_connected()
                house = TestHouse(runtime, field, options, NativeClient)
                async with in_background(house.listen):
                    yield house
