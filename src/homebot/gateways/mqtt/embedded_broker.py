"""The embedded broker, on the usual port or the next free one."""

import errno
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager
from functools import partial

from homebot.clock import Clock
from homebot.devices.health import Count, GetHealth, HealthRequest, HealthResponse
from homebot.errors import LinkError
from homebot.gateways.base import HostService
from homebot.graph import Graph, Node
from homebot.mqtt.broker import Broker, PortTakenError
from homebot.mqtt.clients import HostedBroker
from homebot.support.logger import get_logger

STARTED = "runtime.broker_started"

USUAL_PORTS = range(1883, 1903)

_log = get_logger(node="/homebot")


@asynccontextmanager
async def _host(graph: Graph, clock: Clock) -> AsyncIterator[HostedBroker]:
    async with embedded_broker(graph, clock) as broker:
        yield HostedBroker(broker.url)


EMBEDDED_BROKER = HostService(HostedBroker, _host)


@asynccontextmanager
async def embedded_broker(graph: Graph, clock: Clock, *, ports: Sequence[int] = USUAL_PORTS) -> AsyncIterator[Broker]:
    """Run the embedded broker on 127.0.0.1 and log its port: the first free one of *ports*, or else any free one.

    The service ``/broker/health`` reports its counters and recent losses.
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
    for port in (*ports, 0):  # 0 is any free one
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
    raise LinkError("no TCP port is free for the embedded broker")
