"""A client that shows every packet."""

from collections.abc import AsyncIterator, Awaitable, Callable
from functools import partial

import pytest
from tests.mqtt.broker.conftest import WireClient, dialled

from homebot.testing.mqtt import TestBroker

Join = Callable[..., Awaitable[WireClient]]


@pytest.fixture
async def join(mqtt_broker: TestBroker) -> AsyncIterator[Join]:
    """Log a client in at ``mqtt_broker``."""
    async with dialled() as dial:
        yield partial(dial, mqtt_broker)
