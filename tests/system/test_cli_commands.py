"""What the command line does with a gateway's answer to a message of its own, against homebots that run."""

from collections.abc import Iterator

import pytest
from tests.system.attack_probe import Attacked, attacked

from homebot.cli.door_client import open_door
from homebot.cli.publishing import GatewayPublisher
from homebot.cli.server_address import ServerAddress
from homebot.errors import RefusedError

pytestmark = pytest.mark.system


@pytest.fixture(scope="module")
def acting(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Attacked]:
    with attacked(tmp_path_factory.mktemp("acting")) as homebot:
        yield homebot


@pytest.fixture(scope="module")
def observing(acting: Attacked, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Attacked]:
    """On the broker of the other."""
    broker = f"mqtt://127.0.0.1:{acting.broker}"
    with attacked(tmp_path_factory.mktemp("observing"), "--mqtt", broker, "--root", "home425") as homebot:
        yield homebot


def publish(homebot: Attacked, address: str) -> None:
    with open_door(ServerAddress("127.0.0.1", homebot.door)) as door:
        GatewayPublisher(door).publish("mqtt", address, "open")


def test_a_message_that_is_sent_ends_well(acting: Attacked) -> None:
    publish(acting, "home425/windows/firstlevel1/in")


def test_a_message_that_the_gateway_refuses_is_told_with_its_reason(acting: Attacked) -> None:
    for _ in range(2):
        with pytest.raises(RefusedError, match=r"the command to home425/# was refused: .*(wildcard|gateway's log)"):
            publish(acting, "home425/#")


def test_a_gateway_that_only_observes_is_told(observing: Attacked) -> None:
    with pytest.raises(RefusedError, match="the gateway only observes; start with --act, or set act = true"):
        publish(observing, "home425/windows/firstlevel1/in")
