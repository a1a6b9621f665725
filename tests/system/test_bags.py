"""Bags of a running homebot; the commands are those of docs/bags.md."""

import math
import re
import signal
from dataclasses import replace
from pathlib import Path

import pytest
from tests.features.bags.bags import CHAT, START, bag_of, topic, words
from tests.guide import commands_in, guide
from tests.patience import PATIENCE
from tests.shell import Homebot, homebot_in, publish, publish_raw
from tests.system.attack_probe import until

from homebot.features.bags.bag_topic import BagMessage, BagTopic
from homebot.features.bags.bag_writer import BagWriter
from homebot.features.bags.mcap_file import McapFile
from homebot.messages.cdr import message_to_cdr
from homebot.messages.std_msgs import Float64MultiArray, MultiArrayLayout

GUIDE = guide("bags")
COMMANDS = commands_in(GUIDE)
RECORD, RECORD_FILE, INFO, PLAY, RECOVER, EXPORT = COMMANDS

HOUSE = """
[rooms.hall]
[devices.hall_lamp]
kind = "lamp"
room = "hall"
"""


def ok(shell: Homebot, command: str) -> str:
    done = shell.run(command)
    assert (done.returncode, done.stderr) == (0, ""), done.stdout
    return done.stdout


def is_on(shell: Homebot) -> bool:
    return shell.run("homebot find 'hall_lamp on'").stdout.startswith("DEVICE")


def test_topics_are_recorded_and_played(tmp_path: Path) -> None:
    (tmp_path / "homebot.toml").write_text("[gateways.mqtt]\n")  # no light_service, which turns off what is played
    with homebot_in(tmp_path, house=HOUSE, until=("found", "is running")) as shell:
        recorder = shell.begin(RECORD)
        while not (tmp_path / "day").exists():
            assert recorder.poll() is None
        publish(shell.door, "/hello", "std_msgs/String", {"data": "hi"}, 20)  # longer than a look for new topics takes
        publish_raw(shell.door, "home425/lights/hall_lamp/in", "on", 20)
        until(lambda: shell.run("homebot do hall_lamp off").returncode == 0 or None, PATIENCE)  # within its rate limit
        recorder.send_signal(signal.SIGINT)
        out, err = recorder.communicate(timeout=PATIENCE)
        assert (recorder.returncode, err) == (0, "")
        assert re.fullmatch(r"day: \d+ messages; topics: \d+\n", out)
        told = ok(shell, INFO)
        assert re.search(r"/hello \| std_msgs/msg/String \| \d+\n", told)
        assert re.search(r"/gateway/mqtt/received_topics \| homebot/msg/Sighting \| [1-9]", told)  # it is latched

        reader = shell.begin("homebot topic echo --once --json /hello")
        assert reader.stderr is not None
        assert "no topic /hello yet" in reader.stderr.readline()
        played = ok(shell, PLAY)
        assert reader.communicate(timeout=PATIENCE)[0] == '{"data": "hi"}\n'
        assert re.search(r"left out, as they are commands \(--commands plays them\): /gateway/mqtt/out\n", played)
        assert re.search(
            r"left out, as they are homebot's own \(--topics plays them\): .*/gateway/mqtt/readings", played
        )
        assert not is_on(shell)
        ok(shell, f"{PLAY} --rate 1000 --topics /gateway/mqtt/out --commands")
        assert until(lambda: is_on(shell) or None, PATIENCE)


@pytest.mark.slow
def test_a_bag_is_played_as_fast_as_the_door_reads(tmp_path: Path) -> None:
    """It was sent at once, and the last call waited too long for its answer."""
    bag_of(tmp_path / "day", 1000)
    (tmp_path / "homebot.toml").write_text("[gateways.mqtt]\n[door]\nmax_frames_per_second = 100\n")
    with homebot_in(tmp_path, house=HOUSE, until=("found", "is running")) as shell:
        assert ok(shell, f"{PLAY} --rate 1000") == "1,000 messages were played; topics: /chat\n"


def test_what_is_played_is_what_was_recorded_also_infinity(tmp_path: Path) -> None:
    """A range finder says so that there is nothing as far as it sees (REP 117)."""
    seen = topic("/ranges", Float64MultiArray)
    layout = MultiArrayLayout(dim=(), data_offset=0)
    data = message_to_cdr(Float64MultiArray(layout=layout, data=(1.5, math.inf, -math.inf, math.nan)))
    with BagWriter(tmp_path / "day") as writer:
        for number in range(30):
            writer.write(BagMessage(seen, START + number * 100_000_000, data))
    (tmp_path / "homebot.toml").write_text("[gateways.mqtt]\n")
    with homebot_in(tmp_path, house=HOUSE, until=("found", "is running")) as shell:
        recorder = shell.begin("homebot bag record -o again.mcap /ranges")
        assert recorder.stderr is not None
        assert "no topic /ranges yet" in recorder.stderr.readline()
        ok(shell, PLAY.replace("--rate 2", ""))
        recorder.send_signal(signal.SIGTERM)
        recorder.communicate(timeout=PATIENCE)
    assert {one.data for one in McapFile(tmp_path / "again.mcap").messages()} == {data}


def test_topics_that_homebot_cannot_read_are_left_out(tmp_path: Path) -> None:
    """Introspection of a service, which rosbag2 records with the text of the service, and a type in IDL."""
    service = "int64 a\nint64 b\n---\nint64 sum\n"
    add = BagTopic("/add/_service_event", "example_interfaces/srv/AddTwoInts_Event", service, "", "")
    idl = replace(CHAT, name="/idl", ros_type="acme_msgs/msg/X", encodings=("cdr", "ros2idl"))
    with BagWriter(tmp_path / "day") as writer:
        for one in (add, idl, CHAT):
            writer.write(next(words(1))._replace(topic=one))
    (tmp_path / "homebot.toml").write_text("[gateways.mqtt]\n")
    with homebot_in(tmp_path, house=HOUSE, until=("found", "is running")) as shell:
        played, *left_out = ok(shell, PLAY).splitlines()
    assert played == "1 messages were played; topics: /chat"
    assert [one.rpartition(": ")[2] for one in left_out] == ["/add/_service_event", "/idl"]


def test_a_topic_that_is_refused_or_a_message_that_is_damaged_costs_itself_alone(tmp_path: Path) -> None:
    """A topic that homebot has with another type, and bytes that are no text."""
    with BagWriter(tmp_path / "day") as writer:
        for number, (one, data) in enumerate(
            [
                (CHAT, next(words(1)).data),
                (replace(CHAT, name="/rosout"), next(words(1)).data),
                (CHAT, b"\x00\x01\x00\x00\xff\xff\xff\xff"),
                (CHAT, next(words(1)).data),
            ]
        ):
            writer.write(BagMessage(one, START + number * 100_000_000, data))
    (tmp_path / "homebot.toml").write_text("[gateways.mqtt]\n")
    with homebot_in(tmp_path, house=HOUSE, until=("found", "is running")) as shell:
        played, *left_out = ok(shell, f"{PLAY} --topics /**").splitlines()
    assert played == "2 messages were played; topics: /chat"
    refused, bad = left_out
    assert re.fullmatch(r"left out, as homebot refuses it \(.+\): /rosout", refused)
    assert bad.startswith("left out, 1 messages of /chat: ")


def test_one_file_has_the_topics_that_were_named(tmp_path: Path) -> None:
    with homebot_in(tmp_path, house=HOUSE, until=("found", "is running")) as shell:
        command = RECORD_FILE.replace("/robots/**", "/gateway/**").replace("60", "1")
        assert re.fullmatch(r"robot.mcap: \d+ messages; topics: \d+\n", ok(shell, command))
        told = ok(shell, INFO.replace("day", "robot.mcap"))
        assert set(re.findall(r"^Topic: +(/\w+)", told, re.MULTILINE)) == {"/gateway"}
        again = shell.run(command)
        assert (again.returncode, "robot.mcap exists already" in again.stderr) == (1, True)


def test_a_topic_that_is_not_there_is_awaited(tmp_path: Path) -> None:
    with homebot_in(tmp_path, house=HOUSE, until=("found", "is running")) as shell:
        recorder = shell.begin(f"{RECORD} hello --for 300")
        assert recorder.stderr is not None
        assert recorder.stderr.readline() == "homebot: no topic /hello yet; waiting, Ctrl-C stops\n"
        while not (tmp_path / "day" / "day_0.mcap").stat().st_size > 500:  # beyond its first bytes
            assert recorder.poll() is None
            publish(shell.door, "/hello", "std_msgs/String", {"data": "hi"}, 5)
        recorder.send_signal(signal.SIGTERM)
        assert re.fullmatch(r"day: [1-9]\d* messages; topics: 1\n", recorder.communicate(timeout=PATIENCE)[0])


def test_a_bag_that_was_cut_off_is_recovered(tmp_path: Path) -> None:
    with homebot_in(tmp_path, house=HOUSE, until=("found", "is running")) as shell:
        ok(shell, f"{RECORD} --for 1")
        file = tmp_path / "day" / "day_0.mcap"
        whole = file.read_bytes()
        file.write_bytes(whole[: whole.index(b"serialized_metadata")])
        broken = shell.run(INFO)
        rescue = "`homebot bag recover day/day_0.mcap NEW` keeps what is whole"
        assert broken.stderr == f"homebot: day/day_0.mcap was cut off or is damaged; {rescue}\n"
        told = ok(shell, RECOVER)
        assert (found := re.fullmatch(r"day/day_0.mcap: (\d+) messages; others are cut off or damaged\n", told))
        assert re.search(rf"^Messages: +{found[1]}$", ok(shell, "homebot bag info whole"), re.MULTILINE)


def test_a_recording_is_exported(tmp_path: Path) -> None:
    with homebot_in(tmp_path, "--record", "house.jsonl.gz", house=HOUSE, until=("found", "is running")) as shell:
        ok(shell, "homebot do hall_lamp on")
    assert re.fullmatch(r"house: \d+ messages\n", ok(shell, EXPORT))
    told = ok(shell, "homebot bag info house")
    for name in ("/gateway/mqtt/readings", "/gateway/mqtt/state", "/recording/commands", "/recording/outcomes"):
        assert name in told


@pytest.mark.parametrize(
    ("command", "told"),
    [
        (INFO, "there is no bag day"),
        (RECOVER, "there is no bag day"),
        (EXPORT, "house.jsonl.gz cannot be read: No such file or directory"),
    ],
)
def test_what_is_missing_is_told_and_nothing_is_written(tmp_path: Path, command: str, told: str) -> None:
    done = Homebot(tmp_path).run(command)
    assert (done.returncode, done.stderr) == (1, f"homebot: {told}\n")
    assert [*tmp_path.iterdir()] == []
