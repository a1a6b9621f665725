"""The bounds, and the address that needs a password."""

from __future__ import annotations

import pytest

from homebot.errors import UsageError
from homebot.mqtt.broker import Broker, BrokerLimits
from homebot.mqtt.broker.authentication import Authentication


@pytest.mark.parametrize(
    "limits", [{"max_inflight": 0}, {"receive_maximum": 65_536}, {"max_packet_size": 2**28 + 5}, {"linger": -1}]
)
def test_bounds_that_cannot_work_are_refused_by_name(limits: dict[str, int]) -> None:
    with pytest.raises(UsageError, match=next(iter(limits))):
        BrokerLimits(**limits)


@pytest.mark.parametrize("host", ["::", "192.168.1.5", "my-computer", ""])
def test_an_address_others_can_reach_needs_a_password(host: str) -> None:
    with pytest.raises(UsageError, match="user and password"):
        Broker(host=host)
    assert Broker(host=host, credentials={"u": "p"}).host == host


@pytest.mark.parametrize("host", ["127.0.0.1", "::1", "localhost", "127.8.8.8"])
def test_this_computer_needs_none(host: str) -> None:
    assert Broker(host=host).port == 0


def test_impossible_arguments_are_refused() -> None:
    with pytest.raises(UsageError, match="65536 is not a TCP port"):
        Broker(port=65_536)
    with pytest.raises(UsageError, match="keep-alive of 0"):
        Broker(keep_alive=0)


def test_passwords_are_shown_nowhere() -> None:
    broker = Broker(credentials={"ann": "hush"})
    assert "hush" not in repr(broker) + repr(vars(broker)) + repr(Authentication({"ann": "hush"}))
