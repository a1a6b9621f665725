"""The embedded broker, on a chosen port, or on the usual one or the next free one."""

import errno
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from functools import cache, partial

from homebot.clock import Clock
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.errors import LinkError
from homebot.gateways.base import HostService
from homebot.gateways.mqtt.settings import USUAL_PORTS
from homebot.graph import Graph, Node
from homebot.mqtt.broker import Broker, PortTakenError
from homebot.mqtt.clients import HostedBroker
from homebot.support.logger import get_logger

STARTED = "runtime.broker_started"

_log = get_logger(node="/homebot")


@cache
def hosted_broker(ports: tuple[int, ...]) -> HostService[HostedBroker]:
    """Return the service that runs the embedded broker on one of *ports*; the same object for the same ones."""

    @asynccontextmanager
    async def start(graph: Graph, clock: Clock) -> AsyncIterator[HostedBroker]:
        async with embedded_broker(graph, clock, ports=ports) as broker:
            yield HostedBroker(broker.url)

    return HostService(HostedBroker, start)


@asynccontextmanager
async def embedded_broker(graph: Graph, clock: Clock, *, ports: Sequence[int] = USUAL_PORTS) -> AsyncIterator[Broker]:
    """Run the embedded broker on 127.0.0.1 and log its port: the first free one of *ports*, of which 0 is any.

    The service ``/broker/health`` reports its counters and recent losses.

    Raises:
        LinkError: None of *ports* is free.
    """
    broker = await _start(clock, ports)
    try:
        taken = f" (port {ports[0]} was taken)" if broker.port != ports[0] else ""
        _log.info(STARTED, message=f"embedded MQTT broker on {broker.url}{taken}", url=broker.url)
        async with Node(graph, "broker") as node:
            node.create_service(GetHealth, "/broker/health", partial(_health, broker))
            yield broker
    finally:
        await broker.stop()


def _health(broker: Broker, _request: HealthRequest) -> HealthResponse:
    lost = broker.losses
    return HealthResponse(
        counts=Count.of(broker.stats),
        troubles=(f"in the last ten minutes it dropped {lost}",) if lost else (),
    )


async def _start(clock: Clock, ports: Sequence[int]) -> Broker:
    for port in ports:
        broker = Broker(port=port, clock=clock)
        try:
            await broker.start()
        except PortTakenError:
            continue
        except OSError as exc:  # programs that start at once may both bind a port, but only one may listen
            if exc.errno != errno.EADDRINUSE:
                raise LinkError(f"the embedded broker cannot listen: {exc.strerror}") from exc
            continue
        return broker
    listed = f"port {ports[0]} is" if len(ports) == 1 else "all ports are"
    raise LinkError(f"the embedded broker cannot listen: {listed} taken")
