"""The gateway's reports of its link to the broker; in virtual time."""

import anyio
import pytest
from structlog.testing import capture_logs
from tests.gateways.mqtt.simple_house import House, settled, simple_house

from homebot.devices import GatewayState
from homebot.graph import qos_profile_latched
from homebot.mqtt.broker import RefusedFilters
from homebot.mqtt.client.memory_transport import MemorySocket
from homebot.mqtt.client.transport import TransportUser

pytestmark = pytest.mark.virtual_time


def freeze(house: House) -> None:
    """Let the broker go on accepting connections and answer nothing any more, as a process that is stopped does."""
    dial = house.broker.dial

    def dial_frozen(host: str, port: int, user: TransportUser) -> MemorySocket:
        socket = dial(host, port, user)
        house.broker.links[-1].freeze()
        return socket

    house.broker.links[-1].freeze()
    house.broker.dial = dial_frozen  # type: ignore[method-assign]


@pytest.mark.parametrize("at", [0.0, 1.0, 29.9, 30.1])
async def test_a_frozen_broker_is_reported_within_one_and_a_half_intervals(at: float) -> None:
    """The loss is reported when it is known, and not when the next try to connect has failed, too."""
    async with simple_house() as house:
        states = house.watcher.create_subscription(
            GatewayState, house.gateway.names.state, qos_profile=qos_profile_latched
        )
        assert (await states.receive()).state == "active"
        await anyio.sleep(at)
        freeze(house)
        began = anyio.current_time()
        with anyio.fail_after(46.0):
            lost = await states.receive()
        assert lost.state == "unavailable"
        assert lost.reason.startswith(f"{house.gateway._connection.url}: ")  # homebot doctor shows it
        assert anyio.current_time() - began <= 41.0


async def test_a_gateway_that_stops_has_lost_nothing(capsys: pytest.CaptureFixture[str]) -> None:
    async with simple_house():
        await settled()
    assert "lost the connection" not in capsys.readouterr().out


async def test_each_lost_link_is_told() -> None:
    """Two outages within seconds are two lines."""
    with capture_logs() as lines:
        async with simple_house() as house:
            for _ in range(2):
                await house.broker.stop()
                await anyio.sleep(1)
                await house.broker.start()
                await anyio.sleep(5)
    assert sum(line["event"] == "gateway.link_lost" for line in lines) == 2


@pytest.mark.rooms("thesis")
@pytest.mark.parametrize(
    ("refused", "state", "outcome"),
    [
        pytest.param(
            ("home425/+/+/out", "home425", "home425/+", "home425/+/+", "home425/+/+/+/+/#"),
            "unavailable",
            "receives nothing",
            id="all",
        ),
        pytest.param(("home425",), "active", "listening to home425", id="one of several"),
    ],
)
async def test_a_broker_that_refuses_subscriptions_is_told_in_one_line(
    refused: tuple[str, ...], state: str, outcome: str
) -> None:
    """Connected is not enough to be well."""
    with capture_logs() as lines:
        async with simple_house(policy=RefusedFilters(refused), conventions=("thesis",)) as house:
            now = await house.watcher.create_subscription(
                GatewayState, house.gateway.names.state, qos_profile=qos_profile_latched
            ).receive()
    assert now.state == state
    assert "refused the subscription to" in now.reason
    (told,) = [line for line in lines if line["event"] == "gateway.subscription_refused"]
    assert outcome in told["message"]


async def test_a_broker_that_is_away_for_hours_is_a_line_every_ten_minutes(capsys: pytest.CaptureFixture[str]) -> None:
    """It was one every ten seconds, 8,640 a day."""
    async with simple_house() as house:
        freeze(house)
        await anyio.sleep(7200)
    assert 2 <= capsys.readouterr().out.count("cannot connect to") <= 13
