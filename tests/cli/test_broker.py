"""``homebot broker``: what it makes of its options, and the process from its first line to its end."""

import json
import signal
import socket
import ssl
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import trustme
from tests.patience import PATIENCE

from homebot.cli import main
from homebot.cli.commands.broker import make_broker
from homebot.cli.main import make_parser
from homebot.mqtt.broker import Broker
from homebot.mqtt.packets import (
    Connack,
    Connect,
    MqttSubscription,
    Packet,
    PacketReader,
    ProtocolVersion,
    ReasonCode,
    Suback,
    Subscribe,
    encode,
)


@pytest.fixture(autouse=True)
def _folder_with_a_password(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name, content in (("password", "hunter2\n"), ("nothing", "\n")):
        Path(name).touch(mode=0o600)
        Path(name).write_text(content)


def broker_of(*arguments: str) -> Broker:
    return make_broker(make_parser().parse_args(["broker", *arguments]))


def test_without_anything_it_is_the_usual_port_of_this_computer() -> None:
    assert broker_of().url == "mqtt://127.0.0.1:1883"


def test_an_address_others_can_reach_is_served_with_a_password() -> None:
    broker = broker_of("--listen", "0.0.0.0:8883", "--user", "home", "--password-file", "password")
    assert broker.url == "mqtt://0.0.0.0:8883"


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--listen", "0.0.0.0:0"], "0.0.0.0 can be reached by others, so it needs a password: give --user and --pa"),
        (["--listen", "[::]:0", "--tls-cert", "x"], ":: can be reached by others, so it needs a password"),
        (["--user", "home"], "give --user and --password-file together"),
        (["--password-file", "password"], "give --user and --password-file together"),
        (["--user", "home", "--password-file", "absent"], "absent cannot be read: No such file or directory"),
        (["--user", "home", "--password-file", "nothing"], "the first line of nothing is empty"),
        (["--tls-key", "key"], "--tls-key needs --tls-cert"),
        (["--tls-cert", "absent"], "certificate absent: No such file or directory"),
        (["--tls-cert", "password"], "certificate: no certificate was found in password"),
        (["--refuse-filter", "a/#/b"], "--refuse-filter: topic filter 'a/#/b' has # before its end"),
        (["--keep-alive", "65536"], "a keep-alive of 65536 s is not from 1 to 65535"),
    ],
)
def test_what_cannot_be_served_is_one_clear_sentence(
    capsys: pytest.CaptureFixture[str], arguments: list[str], problem: str
) -> None:
    assert main(["broker", *arguments]) == 1
    err = capsys.readouterr().err
    assert problem in err
    assert err.count("\n") == 1


def test_a_taken_port_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        assert main(["broker", "--listen", f"127.0.0.1:{port}"]) == 1
    assert capsys.readouterr().err.startswith(f"homebot: port {port} of 127.0.0.1 is taken by another program")


class Running:
    """A broker process that has said where it listens."""

    def __init__(self, *arguments: str) -> None:
        command = [sys.executable, "-m", "homebot", "broker", "--listen", "127.0.0.1:0", "--log-format", "json"]
        self.process = subprocess.Popen([*command, *arguments], stderr=subprocess.PIPE, text=True)
        assert self.process.stderr is not None
        self.greeting: dict[str, Any] = json.loads(self.process.stderr.readline())
        self.port = int(self.greeting["url"].rpartition(":")[2])

    def call(self, *packets: Packet, context: ssl.SSLContext | None = None) -> list[Packet]:
        """Log in as MQTT 5, send each packet, and return one answer each."""
        reader, answers = PacketReader(ProtocolVersion.V5), []
        with socket.create_connection(("127.0.0.1", self.port), timeout=PATIENCE) as plain:
            sock = plain if context is None else context.wrap_socket(plain, server_hostname="127.0.0.1")
            for packet in packets:
                sock.sendall(encode(packet, ProtocolVersion.V5))
                while (answer := reader.pop()) is None:
                    data = sock.recv(4096)
                    assert data, "the broker closed"
                    reader.feed(data)
                answers.append(answer)
            if sock is not plain:
                sock.close()
        return answers

    def end(self) -> list[dict[str, Any]]:
        """Wait for the end and return the rest of its lines; a traceback is no JSON."""
        _, rest = self.process.communicate(timeout=120)
        return [json.loads(line) for line in rest.splitlines()]


Run = Callable[..., Running]


@pytest.fixture
def run() -> Iterator[Run]:
    running: list[Running] = []

    def start(*arguments: str) -> Running:
        running.append(Running(*arguments))
        return running[-1]

    yield start
    for each in running:
        each.process.kill()
        each.process.communicate()


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_in_order_even_with_a_client_connected(run: Run, number: signal.Signals) -> None:
    broker = run()
    assert (
        broker.greeting["message"] == f"MQTT broker listening on mqtt://127.0.0.1:{broker.port}; press Ctrl-C to stop"
    )
    with socket.create_connection(("127.0.0.1", broker.port)) as client:
        client.sendall(encode(Connect("a", ProtocolVersion.V5), ProtocolVersion.V5))
        assert client.recv(4096)
        broker.process.send_signal(number)
        (goodbye,) = broker.end()
    assert broker.process.returncode == 0
    assert goodbye["message"] == "the broker stopped; received 0 messages on 1 connections, sent 0"


def test_keep_alive_and_refused_filters_are_those_of_the_options(run: Run) -> None:
    broker = run("--keep-alive", "1m", "--refuse-filter", "test/nosubscribe", "--refuse-filter", "b")
    filters = tuple(MqttSubscription(each, 1) for each in ("test/nosubscribe", "a", "b"))
    connack, suback = broker.call(Connect("a", ProtocolVersion.V5, keep_alive=120), Subscribe(1, filters))
    assert isinstance(connack, Connack)
    assert connack.properties.server_keep_alive == 60
    assert isinstance(suback, Suback)
    assert suback.reasons == (ReasonCode.UNSPECIFIED_ERROR, ReasonCode.GRANTED_QOS_1, ReasonCode.UNSPECIFIED_ERROR)


def test_it_ends_when_its_time_is_over(run: Run) -> None:
    broker = run("--for", "0.5")
    broker.end()
    assert broker.process.returncode == 0


def test_it_asks_for_the_password_and_speaks_tls(run: Run, tmp_path: Path) -> None:
    authority = trustme.CA()
    server = authority.issue_cert("127.0.0.1")
    server.private_key_pem.write_to_path(tmp_path / "key.pem")
    server.cert_chain_pems[0].write_to_path(tmp_path / "cert.pem")
    login = ["--user", "home", "--password-file", "password"]
    broker = run(*login, "--tls-cert", "cert.pem", "--tls-key", "key.pem")
    assert broker.greeting["url"].startswith("mqtts://")
    context = ssl.create_default_context()
    authority.configure_trust(context)
    reasons = []
    for password in (b"hunter2", b"hunter3"):
        connect = Connect("a", ProtocolVersion.V5, username="home", password=password)
        (connack,) = broker.call(connect, context=context)
        assert isinstance(connack, Connack)
        reasons.append(connack.reason)
    assert reasons == [ReasonCode.SUCCESS, ReasonCode.BAD_USER_NAME_OR_PASSWORD]
