"""What hostile clients of the door do to a homebot, for real over sockets: nobody else waits, and nothing is left.

What an attack costs is printed (``pytest -s``). Asserted are limits that hold on any machine: generous ones for time
and memory, exact ones for what stays open.
"""

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

import pytest
from tests.patience import PATIENCE
from tests.sizes import size
from tests.system.attack_probe import Attacked, Toll, attacked, begun, until
from tests.system.broker_probe import Client as Mqtt
from tests.system.own_time import own_time
from tests.turns import slowness
from websockets.exceptions import InvalidStatus
from websockets.sync.client import ClientConnection, connect

from homebot.devices.names import DEFINE_TYPE
from homebot.mqtt.packets import Connect, MqttSubscription, ProtocolVersion, Publish, Subscribe
from homebot.support.owner_token import OWNER_FILE

pytestmark = [pytest.mark.system, pytest.mark.no_cover]

CLIENTS = 8
MOST_BUSY = 0.05
"""Seconds of the processor between two turns of somebody else, on the reference machine."""

MOST_MEMORY = 150
"""MiB above what it was before, at any time."""


@pytest.fixture(scope="module")
def homebot(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Attacked]:
    with attacked(tmp_path_factory.mktemp("door")) as running:
        begun(running)
        yield running


def client(homebot: Attacked) -> ClientConnection:
    return connect(
        homebot.url, proxy=None, compression=None, open_timeout=PATIENCE, ping_interval=None, close_timeout=1
    )


@contextmanager
def clients(homebot: Attacked, count: int = CLIENTS) -> Iterator[list[ClientConnection]]:
    with ExitStack() as stack:
        yield [stack.enter_context(client(homebot)) for _ in range(count)]


def send(peer: ClientConnection, **frame: object) -> None:
    peer.send(json.dumps(frame))


def settle(peer: ClientConnection) -> list[dict[str, Any]]:
    """Return what came until everything sent before was dealt with."""
    send(peer, op="call_service", id="settle", service="/rosapi/get_time", timeout=PATIENCE)
    frames = []
    while (frame := json.loads(peer.recv(timeout=PATIENCE))).get("id") != "settle":
        frames.append(frame)
    return frames


def leave(peer: ClientConnection) -> None:
    """Hang up without a word, where the door has not done so first."""
    with suppress(OSError):
        peer.socket.shutdown(socket.SHUT_RDWR)


def check(name: str, homebot: Attacked, before: Toll, attack: Callable[[Callable[[], None]], object]) -> None:
    """Run *attack*, print what it cost, and make sure that it cost little and left nothing.

    Args:
        name: What to call it.
        homebot: Who is attacked.
        before: What it was like.
        attack: Is given what it calls while it holds all it has.
    """
    started = time.monotonic()
    during: list[Toll] = []
    result = attack(lambda: during.append(homebot.toll()))
    during.append(homebot.toll())
    after = homebot.settled(before)
    print(f"\n{name} ({time.monotonic() - started:.1f} s{f', {result}' if result else ''})")
    print(f"  before {before}", *(f"  during {one}" for one in during), f"  after  {after}", sep="\n")
    assert max(one.busy for one in during) < MOST_BUSY * slowness()
    assert max(one.rss for one in (*during, after)) < before.rss + MOST_MEMORY
    assert after.is_back_at(before)


def test_many_subscriptions_of_each_of_eight_clients(homebot: Attacked) -> None:
    def attack(hold: Callable[[], None]) -> None:
        with clients(homebot) as peers:
            for number in range(size(300, 1000)):
                for place, peer in enumerate(peers):
                    send(peer, op="subscribe", topic=f"/flood/t{place}_{number}", type="std_msgs/String")
            for peer in peers:
                assert settle(peer) == []
            hold()
            for peer in peers:
                leave(peer)

    check("8 clients, many subscriptions each", homebot, homebot.toll(), attack)


def test_many_subscriptions_to_topics_that_nobody_knows(homebot: Attacked) -> None:
    def attack(_hold: Callable[[], None]) -> None:
        with clients(homebot) as peers:
            for number in range(size(300, 1000)):
                for peer in peers:
                    send(peer, op="subscribe", id=f"{number}", topic=f"/flood/unknown{number % 100}")
            for peer in peers:
                assert settle(peer) == []
            send(peers[0], op="advertise", topic="/flood/unknown7", type="std_msgs/String")
            settle(peers[0])

    check("8 clients wait for topics that nobody knows", homebot, homebot.toll(), attack)


def test_a_flood_of_calls(homebot: Attacked) -> None:
    def attack(_hold: Callable[[], None]) -> str:
        services = ["/rosapi/topics", "/rosapi/nodes", "/nobody", "/rosapi/topics_and_raw_types"]
        with clients(homebot) as peers:
            for number in range(200):
                for peer in peers:
                    send(peer, op="call_service", id=f"{number}", service=services[number % len(services)])
            answers = [frame for peer in peers for frame in settle(peer)]
        refused = sum("calls of this client are under way" in str(frame["values"]) for frame in answers)
        return f"{len(answers)} answers, {refused} refused"

    check("8 clients, 200 calls each", homebot, homebot.toll(), attack)


def test_advertising_and_unadvertising_all_the_time(homebot: Attacked) -> None:
    def attack(_hold: Callable[[], None]) -> None:
        with client(homebot) as peer:
            for number in range(1200):
                send(peer, op="advertise", topic=f"/flood/a{number}", type="std_msgs/String")
                send(peer, op="unadvertise", topic=f"/flood/a{number}")
            assert settle(peer) == []

    check("advertise and unadvertise 1,200 times", homebot, homebot.toll(), attack)


def test_readers_that_read_nothing_and_leave(homebot: Attacked) -> None:
    before = homebot.toll()
    frame = json.dumps({"op": "publish", "topic": "/flood/big", "msg": {"data": "x" * 500_000}})

    def attack(hold: Callable[[], None]) -> None:
        with clients(homebot) as readers, client(homebot) as writer:
            send(writer, op="advertise", topic="/flood/big", type="std_msgs/String")
            settle(writer)
            for reader in readers:
                send(reader, op="subscribe", topic="/flood/big")
            for _ in range(100):
                writer.send(frame)
            settle(writer)
            hold()
            for reader in readers:
                leave(reader)

    for round_ in range(size(1, 3)):
        check(f"8 readers that read nothing, round {round_ + 1}", homebot, before, attack)


def test_calls_whose_answers_nobody_reads(homebot: Attacked) -> None:
    def attack(hold: Callable[[], None]) -> str:
        sent = 0
        with clients(homebot) as peers:
            call = json.dumps({"op": "call_service", "service": "/rosapi/topics_and_raw_types"}).encode()
            for peer in peers:
                peer.socket.setblocking(False)
            deadline = time.monotonic() + 1
            while time.monotonic() < deadline:
                for peer in peers:
                    sent += _send_raw(peer, call)
            hold()
            for peer in peers:
                leave(peer)
        return f"{sent} calls"

    check("calls whose answers nobody reads", homebot, homebot.toll(), attack)


def _send_raw(peer: ClientConnection, text: bytes) -> int:
    """Send a masked text frame past the library, which would wait; return how many were taken whole."""
    try:
        frame = bytes([0x81, 0x80 | len(text)]) + bytes(4) + text
        taken = peer.socket.send(frame)
    except OSError:
        return 0
    while taken < len(frame):  # a frame that was begun is finished, else it is another attack
        try:
            taken += peer.socket.send(frame[taken:])
        except BlockingIOError:
            time.sleep(0.01)
        except OSError:
            return 0
    return 1


def test_pings_that_nobody_asked_for(homebot: Attacked) -> None:
    def attack(_hold: Callable[[], None]) -> str:
        pings = (bytes([0x89, 0x80]) + bytes(4)) * 2000
        sent = 0
        with clients(homebot) as peers:
            for peer in peers:
                peer.socket.setblocking(False)
            deadline = time.monotonic() + 1
            while time.monotonic() < deadline:
                for peer in peers:
                    try:
                        sent += peer.socket.send(pings)
                    except OSError:
                        time.sleep(0.001)
            for peer in peers:
                leave(peer)
        return f"{sent / 6:.0f} pings"

    check("pings whose answers nobody reads", homebot, homebot.toll(), attack)


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ("empty lists", '{"d":[' + "[]," * 300_000 + "[]]}"),
        ("empty texts", '{"d":[' + '"",' * 900_000 + '""]}'),
        ("a text without end", '{"data":"' + '\\"' * 300_000),
        ("unknown fields", "{" + ",".join(f'"{number}":1' for number in range(19_000)) + "}"),
        ("a long text", '{"data":"' + "x" * 1_000_000 + '"}'),
        ("wrong bytes", '{"data":[' + '"",' * 19_000 + '""]}'),
        ("deep nesting", '{"data":' + "[" * 90 + "]" * 90 + "}"),
    ],
)
def test_frames_that_take_long_to_read(homebot: Attacked, what: str, message: str) -> None:
    def attack(_hold: Callable[[], None]) -> str:
        with client(homebot) as peer:
            send(peer, op="advertise", topic="/flood/odd", type="std_msgs/String")
            for _ in range(10):
                peer.send(f'{{"op":"publish","topic":"/flood/odd","msg":{message}}}')
            refused = [frame for frame in settle(peer) if frame["op"] == "status"]
        return f"{len(refused)} refused"

    check(f"10 frames of {what}", homebot, homebot.toll(), attack)


def test_a_definition_with_a_text_that_does_not_end(homebot: Attacked) -> None:
    def attack(_hold: Callable[[], None]) -> str:
        with client(homebot) as peer:
            asked = {"type": "lab_msgs/msg/Text", "definition": "string a " + "\\'" * 20_000}
            send(peer, op="call_service", id="define", service=DEFINE_TYPE, args=asked)
            (answer,) = settle(peer)
        return f"answered {answer['result']}"

    check("a text that does not end", homebot, homebot.toll(), attack)


def test_connections_that_say_nothing(homebot: Attacked) -> None:
    def attack(_hold: Callable[[], None]) -> None:
        with ExitStack() as stack:
            for _ in range(300):
                stack.enter_context(socket.create_connection(("127.0.0.1", homebot.door), timeout=PATIENCE))
            with own_time(homebot.pid) as seconds, client(homebot) as honest:
                settle(honest)
                assert seconds() < 10 * slowness()

    check("300 connections that say nothing", homebot, homebot.toll(), attack)


def test_frames_that_never_end(homebot: Attacked) -> None:
    def attack(hold: Callable[[], None]) -> None:
        half = bytes([0x81, 0xFF]) + (1_000_000).to_bytes(8, "big") + bytes(4) + b"x" * 900_000
        with clients(homebot, 40) as peers:
            for peer in peers:
                peer.socket.sendall(half)
            hold()
            for peer in peers:
                leave(peer)

    check("40 frames that never end", homebot, homebot.toll(), attack)


def test_a_message_of_the_door_reaches_an_honest_client_in_the_middle_of_it(homebot: Attacked) -> None:
    """And the answer to a call takes no longer than the share of the loop that others have."""
    waits = []
    with clients(homebot) as peers, client(homebot) as honest:
        settle(honest)
        for number in range(200):
            for peer in peers:
                send(peer, op="subscribe", topic=f"/flood/h{number}", type="std_msgs/String")
            if number % 10 == 0:
                with own_time(homebot.pid) as seconds:
                    settle(honest)
                    waits.append(seconds())
    print(f"\nanswers amid a flood: worst {max(waits) * 1000:.0f} ms of {len(waits)}")
    assert max(waits) < 5 * slowness()


def test_guessed_tokens_wait_longer_and_longer(tmp_path: Path) -> None:
    with attacked(tmp_path, token="hunter2") as locked:
        started = time.monotonic()
        answers: list[int] = []
        while time.monotonic() - started < 2.5:
            try:
                connect(f"{locked.url}?token={len(answers)}", proxy=None, open_timeout=PATIENCE).close()
            except InvalidStatus as exc:
                answers.append(exc.response.status_code)
        took = time.monotonic() - started
        print(f"\n{len(answers)} guesses in {took:.1f} s")
        assert set(answers) == {401}
        assert len(answers) < 20
        with own_time(locked.pid) as seconds:
            locked.toll()
            assert seconds() < 5 * slowness()
        assert "wrong token" in locked.text() or "a valid token is needed" in locked.text()


def test_twelve_guessers_do_not_lock_out_the_program_that_came_in_before(tmp_path: Path) -> None:
    secret = "a-token-nobody-guesses"
    with attacked(tmp_path, token=secret) as locked, ThreadPoolExecutor() as threads:
        is_over = threading.Event()

        def guess() -> int:
            tried = 0
            while not is_over.is_set():
                tried += 1
                with suppress(InvalidStatus):
                    connect(f"{locked.url}?token=wrong{tried}", proxy=None, open_timeout=PATIENCE).close()
            return tried

        begun(locked)  # comes in with the token
        guessers = [threads.submit(guess) for _ in range(12)]
        try:
            until(lambda: True if "too many wrong tokens" in locked.text() else None, PATIENCE)
            tolls = [locked.toll() for _ in range(20)]
        finally:
            is_over.set()
        tried = sum(one.result() for one in guessers)
        print(f"\n{tried} guesses of 12 guessers while the honest client came in 20 times: {tolls[-1]}")
        assert max(one.busy for one in tolls[1:]) < MOST_BUSY * slowness()


LOCK = {"name": "Front door", "unique_id": "front", "command_topic": "front/set", "state_topic": "front/state"}
HOUSE = """
[gateways.mqtt]
[door.tokens.lamps]
token_file = "lamps.token"
scope = ["read", "act: light"]
[door.tokens.keys]
token_file = "keys.token"
scope = ["read", "act: lock"]
"""
UNLOCK = {"target": "Front door", "command": "unlock", "issuer": "client:keys", "scope": ["act: all"]}
FORGED = [
    ("/gateway/mqtt/out", "homebot/msg/RawCommand", {"address": "front/set", "payload": "UNLOCK"}),
    ("/gateway/mqtt/received_topics", "homebot/msg/Sighting", {"gateway": "mqtt", "key": "locks/forged"}),
    ("/gateway/mqtt/readings", "homebot/msg/Report", {"gateway": "mqtt", "key": "front"}),
    ("/discovery/states", "homebot/msg/StateChange", {}),
    ("/control/events", "homebot/msg/CommandEvent", {}),
    ("/loop_probe/inbox", "homebot/msg/RawMessage", {}),
]


@contextmanager
def guest(homebot: Attacked, token: str = "") -> Iterator[ClientConnection]:
    """Connect as a program with *token*."""
    headers = {"Authorization": f"Bearer {token}"} if token else {}
    with connect(homebot.url, additional_headers=headers, proxy=None, open_timeout=PATIENCE) as peer:
        yield peer


def owner_of(folder: Path) -> str:
    """Return the owner's token of the homebot in *folder*."""
    return (folder / "data" / OWNER_FILE).read_text().strip()


def call(peer: ClientConnection, service: str, **arguments: object) -> dict[str, Any]:
    send(peer, op="call_service", id="call", service=service, args=arguments, timeout=PATIENCE)
    while (frame := json.loads(peer.recv(timeout=PATIENCE))).get("id") != "call":
        pass
    answer: dict[str, Any] = frame
    return answer


def check_journal(entries: list[dict[str, Any]], lock: str) -> None:
    """Each request that the door refused is in the journal, by whom and why, and so is each refused command."""
    wanted = {(op, topic) for op in ("advertise", "publish") for topic, _, _ in FORGED}
    wanted.add(("call_service", "/gateway/mqtt/send_command"))
    for issuer in ("client:local", "client:lamps"):
        denied = [one for one in entries if (one["kind"], one["issuer"]) == ("denied", issuer)]
        facts = [{one["name"]: one["value"] for one in entry["verdicts"][0]["facts"]} for entry in denied]
        assert {(one["operation"], one["target"]) for one in facts} == wanted
        assert all(entry["verdicts"][0]["reason"].startswith("the right raw is missing; ") for entry in denied)
        assert [(entry["device"], entry["text"]) for entry in denied if entry["text"]] == [(lock, "UNLOCK")]
        outcomes = [one for one in entries if (one["kind"], one["issuer"]) == ("outcome", issuer)]
        assert [one["results"][0]["policy"] for one in outcomes] == ["rights"]


@pytest.mark.rooms("homeassistant")
def test_a_program_without_the_right_opens_no_lock_and_forges_nothing(tmp_path: Path) -> None:
    """On a real broker: what the lock hears is the command of the one program that may unlock it."""
    (tmp_path / "homebot.toml").write_text(HOUSE)
    for name in ("lamps", "keys"):
        (tmp_path / f"{name}.token").touch(mode=0o600)
        (tmp_path / f"{name}.token").write_text(f"{name}-secret")
    with attacked(tmp_path, "--config", "homebot.toml") as homebot:
        opened = socket.create_connection(("127.0.0.1", homebot.broker), timeout=PATIENCE)
        with opened, guest(homebot, owner_of(tmp_path)) as watcher:
            lock = Mqtt(opened, Connect("lock", ProtocolVersion.V5))
            config = json.dumps(LOCK).encode()
            lock.send(Subscribe(1, (MqttSubscription("front/set", 0),)))
            lock.send(
                Publish("homeassistant/lock/front/config", config, 0, retain=True), Publish("front/state", b"LOCKED")
            )
            while not (known := call(watcher, "/discovery/find_devices")["values"]["devices"]):
                pass
            assert call(watcher, "/discovery/approve", device=known[0]["id"])["values"]["success"]
            for token in ("", "lamps-secret"):
                with guest(homebot, token) as peer:
                    for topic, ros_type, message in FORGED:
                        send(peer, op="advertise", topic=topic, type=ros_type)
                        send(peer, op="publish", topic=topic, msg=message)
                    told = settle(peer)
                    assert [one["level"] for one in told] == ["error"] * 2 * len(FORGED)
                    assert all(one["msg"].startswith("the right raw is missing; ") for one in told)
                    sent = call(peer, "/gateway/mqtt/send_command", key="front", part="", capability="lock")
                    assert (sent["result"], sent["values"][:26]) == (False, "the right raw is missing; ")
                    answer = call(peer, "/devices/command", **UNLOCK)["values"]
                    assert (answer["outcome"], answer["results"][0]["result"]["policy"]) == ("refused", "rights")
            found = call(watcher, "/discovery/find_devices")["values"]["devices"]
            assert [one["name"] for one in found] == ["Front door"]
            with guest(homebot, "keys-secret") as keys:
                send(keys, op="call_service", id="unlock", service="/devices/command", args=UNLOCK, timeout=PATIENCE)
                while not isinstance(heard := lock.take(), Publish):
                    pass
                assert heard.payload == b"UNLOCK"
                lock.send(Publish("front/state", b"UNLOCKED"))
                assert json.loads(keys.recv(timeout=PATIENCE))["values"]["outcome"] == "confirmed"
            counts = {
                one["name"]: one["count"] for one in call(watcher, "/rosbridge_websocket/health")["values"]["counts"]
            }
            assert counts["rights_missing"] == 2 * (2 * len(FORGED) + 1)
            check_journal(call(watcher, "/control/journal")["values"]["entries"], known[0]["id"])
        assert "secret" not in homebot.text()
        assert "client:lamps" in homebot.text()
