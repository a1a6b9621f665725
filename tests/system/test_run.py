"""``homebot run`` as a process of its own: how it starts, what it says, and how it stops."""

import contextlib
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from tests.ports import reserve_port
from tests.system.own_time import own_time_until_end
from tests.turns import slowness
from tests.whole_house import WHOLE_HOUSE

STOPS_WITHIN = 5.0

CUT_OFF_WITHIN = STOPS_WITHIN + 2.0
"""Where a thread ends the program after 4.8 s, which has to wait for a processor like everybody else."""

SETTINGS = {name: value for name, value in os.environ.items() if not name.startswith("HOMEBOT_")}


class Run:
    """A ``homebot run`` whose log is read line by line."""

    def __init__(self, folder: Path, *arguments: str, **settings: str) -> None:
        self.port = reserve_port()
        door = () if {"--door", "--no-door"} & {*arguments} else ("--door", f"127.0.0.1:{self.port}")
        arguments = tuple(one for one in arguments if one != "--no-door")
        self.process = subprocess.Popen(
            [sys.executable, "-m", "homebot", "run", *door, *arguments],
            stderr=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            text=True,
            cwd=folder,
            env={**SETTINGS, "HOMEBOT_DATA": str(folder / "data"), **settings},
            process_group=0,
        )
        self.log: list[str] = []

    def until(self, words: str) -> str:
        """Read the log up to the line that holds *words* and return it."""
        assert self.process.stderr is not None
        guard = threading.Timer(120, self.process.kill)
        guard.start()
        for line in self.process.stderr:
            self.log.append(line)
            if words in line:
                guard.cancel()
                return line
        pytest.fail(f"{words!r} did not come:\n{''.join(self.log)}")

    def stop(self, number: signal.Signals = signal.SIGTERM, within: float = STOPS_WITHIN) -> int:
        """Send a signal, read the rest of the log, and return the exit code; it must come in time."""
        self.process.send_signal(number)
        assert own_time_until_end(self.process) < within * slowness()
        return self.end()

    def end(self) -> int:
        _, rest = self.process.communicate(timeout=120)
        self.log += rest.splitlines(keepends=True)
        return self.process.returncode

    def has_left_nothing(self) -> bool:
        """Return whether no process of it is left, and with that no port that it listened on."""
        try:
            os.killpg(self.process.pid, 0)
        except ProcessLookupError:
            return True
        return False

    @property
    def text(self) -> str:
        return "".join(self.log)


Start = Callable[..., Run]


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    runs: list[Run] = []

    def make(*arguments: str, **settings: str) -> Run:
        runs.append(Run(tmp_path, *arguments, **settings))
        return runs[-1]

    yield make
    for run in runs:
        run.process.kill()
        run.process.wait()
        if run.process.stderr is not None:
            run.process.stderr.close()


def is_free(port: int) -> bool:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        return probe.connect_ex(("127.0.0.1", port)) != 0


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_it_in_order(start: Start, number: signal.Signals) -> None:
    """Exit code 0, no traceback, and nothing is left that could hold a port."""
    run = start("--house", "thesis")
    run.until("roomlights405 → off")
    assert not is_free(run.port)
    assert not run.has_left_nothing()

    assert run.stop(number) == 0
    assert "Traceback" not in run.text
    assert is_free(run.port)
    assert run.has_left_nothing()


def _cli(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "homebot", *arguments]
    return subprocess.run(command, cwd=folder, env=SETTINGS, capture_output=True, text=True, check=False, timeout=120)


def test_a_hangup_reloads_the_tokens_and_says_what_waits_for_a_restart(start: Start, tmp_path: Path) -> None:
    """It ended homebot, and with it the light."""
    file = tmp_path / "homebot.toml"
    file.write_text('[gateways.mqtt]\nurl = "embedded"\n')
    assert _cli(tmp_path, "token", "new", "first", "--scope", "read").returncode == 0
    run = start()
    run.until("is running")
    door = f"127.0.0.1:{run.port}"
    made = _cli(tmp_path, "token", "new", "second", "--scope", "read")
    assert "kill -HUP" in made.stdout
    nodes = ("--door", door, "--token-file", "second.token", "node", "list")
    assert "a valid token is needed" in _cli(tmp_path, *nodes).stderr
    with file.open("a") as text:
        text.write("[control]\ntimeout = '7s'\n")
    run.process.send_signal(signal.SIGHUP)
    assert "restart homebot for the changes of control.timeout" in run.until("were reloaded")
    assert _cli(tmp_path, *nodes).returncode == 0

    good = file.read_text()
    file.write_text(good.replace("timeout", "tmeout"))
    run.process.send_signal(signal.SIGHUP)
    assert "control.tmeout: unknown key; did you mean timeout or time_zone?" in run.until("nothing was reloaded: ")
    assert _cli(tmp_path, *nodes).returncode == 0

    file.unlink()  # as some editors do for a moment
    run.process.send_signal(signal.SIGHUP)
    assert "homebot.toml does not exist" in run.until("nothing was reloaded: ")
    assert _cli(tmp_path, *nodes).returncode == 0

    file.write_text(good.partition("[door.tokens.second]")[0])
    run.process.send_signal(signal.SIGHUP)
    run.until("were reloaded")
    assert "a valid token is needed" in _cli(tmp_path, *nodes).stderr

    file.write_text("")  # as a program that saves it does for a moment
    run.process.send_signal(signal.SIGHUP)
    assert "homebot.toml lacks what it had before: [gateways], [door.tokens]; " in run.until("nothing was reloaded: ")
    reload = ("--door", door, "--token-file", "data/owner.token", "reload")
    refused = _cli(tmp_path, *reload)
    assert refused.returncode == 1
    assert "lacks what it had before" in refused.stderr
    meant = _cli(tmp_path, *reload, "--allow-removal")
    assert meant.stdout == (
        "tokens, rights, policies and places were reloaded; restart homebot for the changes of gateways.mqtt\n"
    )
    assert run.stop() == 0


def test_a_service_manager_is_informed(tmp_path: Path) -> None:
    """As systemd does it for a unit of Type=notify with a watchdog."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(str(tmp_path / "notify"))
        manager.settimeout(120)
        (tmp_path / "homebot.toml").write_text('[gateways.mqtt]\nurl = "embedded"\n')
        run = Run(tmp_path, NOTIFY_SOCKET=str(tmp_path / "notify"), WATCHDOG_USEC="300000")
        try:
            received = [manager.recv(4096).decode() for _ in range(3)]
            assert (received[0], set(received[1:])) == ("READY=1", {"WATCHDOG=1"})
            run.process.send_signal(signal.SIGHUP)
            later = [manager.recv(4096).decode()]
            while later[-1] != "READY=1":
                later.append(manager.recv(4096).decode())
            assert any(re.fullmatch(r"RELOADING=1\nMONOTONIC_USEC=\d+", one) for one in later)
            assert run.stop() == 0
            manager.settimeout(0)
            last = manager.recv(4096).decode()
            while last == "WATCHDOG=1":
                last = manager.recv(4096).decode()
            assert last == "STOPPING=1"
        finally:
            run.process.kill()


def test_a_service_without_a_configuration_runs_no_simulated_house(start: Start) -> None:
    run = start(NOTIFY_SOCKET="/nowhere")
    assert run.end() == 2
    assert run.log == [
        "homebot: homebot.toml does not exist, and a service runs no simulated house; give --config FILE\n"
    ]


HANGUP = """
import os, signal
import anyio
from homebot import App

os.kill(os.getpid(), signal.SIGHUP)

class Idle(App):
    async def run(self):
        await anyio.sleep_forever()
"""


def test_a_hangup_during_the_start_reloads_once_it_runs(start: Start, tmp_path: Path) -> None:
    """The module of the app is loaded long before the event loop runs."""
    (tmp_path / "homebot.toml").write_text('[gateways.mqtt]\nurl = "embedded"\n')
    (tmp_path / "idle.py").write_text(HANGUP)
    run = start("--app", "idle.py")
    run.until("is running")
    run.until("were reloaded")
    assert run.stop() == 0


def test_a_hangup_that_is_ignored_as_under_nohup_reloads_and_stops_nothing(start: Start, tmp_path: Path) -> None:
    (tmp_path / "homebot.toml").write_text('[gateways.mqtt]\nurl = "embedded"\n')
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)  # which a program hands on to those that it starts
    try:
        run = start()
    finally:
        signal.signal(signal.SIGHUP, before)
    run.until("is running")
    run.process.send_signal(signal.SIGHUP)
    run.until("reload")
    assert run.stop() == 0
    assert "SIGHUP" not in run.text


@WHOLE_HOUSE
def test_the_json_log_is_json_line_by_line_until_for_ends_the_run(start: Start) -> None:
    run = start("--log-format", "json", "--for", "2")
    assert run.end() == 0
    events = [json.loads(line)["event"] for line in run.log]
    assert events[0] == "runtime.broker_started"
    assert events.count("runtime.stopping") == 1


def test_a_gateway_without_an_address_has_the_embedded_broker(start: Start, tmp_path: Path) -> None:
    """And acts on it, because only our own devices are there; no house is simulated in a home of your own."""
    (tmp_path / "homebot.toml").write_text('[gateways.mqtt]\nroot = "villa"\n[apps.light_service]\n')
    run = start()
    broker = re.search(r"mqtt://\S+:\d+", run.until("embedded MQTT broker"))
    run.until("connected to mqtt://")
    assert "(observing only)" not in run.text
    run.until("is running")
    assert broker is not None
    assert run.stop() == 0
    assert "found" not in run.text


def test_an_absent_broker_is_told_and_does_not_delay_the_stop(start: Start) -> None:
    """The one who ends it has waited long enough."""
    port = reserve_port()
    run = start("--mqtt", f"mqtt://127.0.0.1:{port}", "--app", "light_service")
    line = run.until("cannot connect to")
    assert line.count(f"mqtt://127.0.0.1:{port}") == 1
    assert run.stop(signal.SIGINT, within=1.5) == 0
    assert "Traceback" not in run.text


def test_a_run_for_a_time_without_its_broker_fails_and_names_the_gateway_and_the_reason_at_the_end(
    start: Start,
) -> None:
    run = start("--mqtt", f"mqtt://127.0.0.1:{reserve_port()}", "--for", "0.5")
    assert run.end() == 1
    assert "never connected in 0.5 s: gateway mqtt: mqtt://127.0.0.1:" in run.log[-1]


@pytest.mark.parametrize("moment", ["while it starts", "while it runs"])
def test_a_broker_that_takes_the_connection_and_says_nothing_does_not_delay_the_stop(start: Start, moment: str) -> None:
    """It hangs; we do not."""
    with socket.create_server(("127.0.0.1", 0)) as broker:
        run = start("--mqtt", f"mqtt://127.0.0.1:{broker.getsockname()[1]}")
        if moment == "while it runs":
            run.until("is running")
        connection, _ = broker.accept()
        with connection:
            assert run.stop() == 0
    assert "Traceback" not in run.text


@WHOLE_HOUSE
def test_a_door_that_is_taken_is_a_clear_error_before_anything_starts(start: Start) -> None:
    """Beside a homebot of the same folder it came after 11 s, in which the gateways connected and waited for files."""
    with socket.create_server(("127.0.0.1", 0)) as taken:
        address = f"127.0.0.1:{taken.getsockname()[1]}"
        run = start("--door", address)
        assert run.end() == 1
    assert run.log[-1].startswith(f"homebot: door: {address} is in use, maybe by another homebot; stop that one, or ")
    assert run.log[-1].endswith("choose another port (--door or [door] port)\n")
    assert len(run.log) == 1
    assert run.has_left_nothing()


@WHOLE_HOUSE
def test_a_usual_port_that_is_taken_moves_on_and_says_so(start: Start) -> None:
    """A homebot in this folder did not start, and the tools acted in the house of the one on 9090."""
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError):
            stack.enter_context(socket.create_server(("127.0.0.1", 9090)))
        run = start("--no-door")
        line = run.until("tools here need --door")
        port = re.search(r"listening on (\d+)", line)
        assert port is not None
        assert port[1] in run.until("listening for rosbridge clients on")
        assert 9090 < int(port[1]) < 9100


@WHOLE_HOUSE
def test_a_door_for_everybody_needs_a_token_and_takes_it_from_the_environment(start: Start) -> None:
    """The token itself is shown nowhere."""
    address = f"0.0.0.0:{reserve_port()}"
    closed = start("--door", address)
    assert closed.end() == 1
    assert "door.host: 0.0.0.0 can be reached by others, so it needs a token" in closed.text

    run = start("--door", address, HOMEBOT_DOOR_TOKEN="hunter2")
    run.until("is running")
    assert run.stop() == 0
    assert "hunter2" not in run.text
