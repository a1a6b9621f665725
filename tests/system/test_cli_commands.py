"""What the command line says of commands, against homebots that run: a no is told, and the exit code is one."""

from collections.abc import Iterator

import pytest
from tests.system.attack_probe import Attacked, attacked

from homebot.cli import main

pytestmark = pytest.mark.system

Text = pytest.CaptureFixture[str]


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


def publish(homebot: Attacked, address: str) -> int:
    command = f"{{address: '{address}', payload: open}}"
    door = f"127.0.0.1:{homebot.door}"
    return main(["--door", door, "topic", "pub", "--once", "/gateway/mqtt/out", command])


def test_a_command_that_is_sent_ends_well(acting: Attacked, capsys: Text) -> None:
    assert publish(acting, "home425/windows/firstlevel1/in") == 0
    assert capsys.readouterr().err == ""


def test_a_command_that_the_gateway_refuses_is_told_with_its_reason(acting: Attacked, capsys: Text) -> None:
    for _ in range(2):
        assert publish(acting, "home425/#") == 1
        out, err = capsys.readouterr()
        assert out == ""
        assert err.startswith("homebot: the command to home425/# was refused: ")
        assert "has a wildcard" in err or "see the gateway's log" in err


def test_a_gateway_that_only_observes_is_told(observing: Attacked, capsys: Text) -> None:
    assert publish(observing, "home425/windows/firstlevel1/in") == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert "was refused: the gateway only observes; start with --act, or set act = true" in err
