"""``homebot leases`` and ``homebot release``, against a real directory and control layer."""

import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest
from tests.cli.conftest import NOW, HomebotWith
from tests.cli.test_approve import home
from tests.patience import PATIENCE
from websockets.sync.client import connect

from homebot.cli import main
from homebot.clock import ManualClock

Run = Callable[..., tuple[int, str, str]]

LOG_LINE = re.compile(r"\[\w+ *\] ")
"""The begin of a line in the log of the home, which runs in the same process."""

HOLD = {
    "device": "lamp",
    "part": "l",
    "setting": {"capability": "on_off", "value": {"type": 1, "flag": True}},
    "lease": "1",
    "by": "robot",
    "ttl": 60,
    "issuer": "",
}


@pytest.fixture
def door(homebot_with: HomebotWith) -> str:
    """Return the address of a home whose lamp nobody answers for."""
    return homebot_with(home, ManualClock(NOW)).door


@contextmanager
def holding(door: str, **changes: object) -> Iterator[None]:
    """Hold the lamp inside the block."""
    with connect(f"ws://{door}", proxy=None) as peer:
        peer.send(json.dumps({"op": "call_service", "service": "/control/hold", "args": HOLD | changes}))
        assert json.loads(peer.recv(timeout=PATIENCE))["values"]["held"]
        yield


@pytest.fixture
def run(door: str, capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs a command; returns its exit code and what it printed."""

    def homebot(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()  # the log of what came before
        code = main(["--door", door, *arguments])
        out, err = capsys.readouterr()
        lines = (line for line in out.splitlines() if not LOG_LINE.match(line))
        return code, "\n".join(" ".join(line.split()) for line in lines), err

    return homebot


def test_a_lease_of_one_gang_of_several_says_which(run: Run, door: str) -> None:
    with holding(door, device="double_switch", part="left"):
        assert run("leases")[1] == "DEVICE HELD BY ISSUER FOR\ndouble_switch#left on robot the client local 1 min"


def test_a_lease_ends_with_the_connection_that_took_it(run: Run) -> None:
    assert "held: true" in run("service", "call", "/control/hold", json.dumps(HOLD))[1]
    assert run("leases")[1].endswith("nobody holds anything")


def test_a_lease_is_listed_and_ended(run: Run, door: str) -> None:
    assert run("leases") == (0, "nobody holds anything", "")
    assert run("release", "Lamp") == (1, "", "homebot: nobody holds lamp\n")
    with holding(door):
        assert run("leases")[1] == "DEVICE HELD BY ISSUER FOR\nlamp on robot the client local 1 min"
        assert run("leases", "Front door")[1] == "nobody holds Front door"
        (held,) = json.loads(run("leases", "Lamp", "--json")[1])
        (holder,) = held["holders"]
        assert (held["device"], held["capability"], held["value"]) == ("lamp", "on_off", True)
        assert held["outranked_until"] is None
        assert (holder["by"], holder["issuer"], holder["until"][-1]) == ("robot", "client:local", "Z")
        code, printed, _ = run("release", "Lamp")
        assert (code, printed.splitlines()[-1]) == (0, "lamp is no longer held on by robot (the client local)")
        assert run("leases")[1] == "nobody holds anything"
        assert "ended the lease by which robot held Lamp" in run("journal")[1]
        assert run("journal", "--json")[1].count('"kind": "ended"') == 1
