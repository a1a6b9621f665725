"""The commands, in this process, against a running homebot."""

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from homebot.cli import main
from homebot.cli.device_json import json_text, list_text
from homebot.graph import EntityKind, Graph, Node, qos_profile_latched
from homebot.graph.endpoint import EndpointInfo
from homebot.messages import String

Text = pytest.CaptureFixture[str]


def run(homebot: Any, *arguments: str) -> int:
    return main(["--door", homebot.door, *arguments])


SWITCH = "std_srvs/srv/SetBool"
PRINTED = {
    "topic list": (0, "/chatter\n/hello\n/parameter_events\n/raw\n/state\n/ticks\n"),
    "topic echo --once /state": (0, 'data: "it\'s on: 5 lamps"\n---\n'),
    "topic echo raw --once": (
        0,
        'gateway: mqtt\nkey: k\naddress: a/b\npayload: "on"\nretained: false\n'
        "received_at:\n  sec: 1700000000\n  nanosec: 250000000\n---\n",
    ),
    "topic echo --once --field received_at.sec /raw": (0, "1700000000\n---\n"),
    "topic echo --once --field received_at.secs /raw": (
        1,
        "homebot: the message has no field 'received_at.secs': 'secs' is not there; it has sec, nanosec\n",
    ),
    "topic echo --timeout 0.05 /chatter": (1, "homebot: no message on /chatter within 0.05 s\n"),
    "topic echo --timeout 0.05 /nope": (
        1,
        "homebot: no topic /nope yet; waiting, Ctrl-C stops\nhomebot: no message on /nope within 0.05 s\n",
    ),
    "service call /switch {data: true}": (0, "success: true\nmessage: done\n"),
    "service call /zzzz": (
        1,
        "homebot: there is no service /zzzz; `homebot service list` lists all\n",
    ),
    "service call /swich": (1, "homebot: there is no service /swich; did you mean /switch?\n"),
    "service call /switch": (  # a field that is missing is false, as in ROS
        1,
        "success: false\nmessage: done\nhomebot: /switch reported a failure: done\n",
    ),
    "service call /switch {dat: true}": (
        1,
        f"homebot: service /switch failed: not a {SWITCH}_Request: field 'dat' is unknown\n",
    ),
    "service call /switch true": (
        1,
        "homebot: 'true' was taken as a type; write the request as {data: true}\n",
    ),
    "service call /switch data=true": (
        1,
        "homebot: 'data=true' was taken as a type; write the request as {data: true}\n",
    ),
    "service call /switch SetBool {data: true}": (1, f"homebot: service /switch is a {SWITCH}, not a SetBool\n"),
    "service call /switch std_srvs/Trigger": (1, f"homebot: service /switch is a {SWITCH}, not a std_srvs/Trigger\n"),
    "service type /switch": (0, f"{SWITCH}\n"),
    "service type /swich": (1, "homebot: there is no service /swich; did you mean /switch?\n"),
    "interface show std_srvs/srv/SetBool": (0, "bool data\n---\nbool success\nstring message\n"),
    "interface show std_msgs/Header": (
        0,
        "builtin_interfaces/Time stamp\n  int32 sec\n  uint32 nanosec\nstring frame_id\n",
    ),
    "interface show std_srvs/srv/SetBol": (
        1,
        "homebot: there is no type 'std_srvs/srv/SetBol'; did you mean std_srvs/srv/SetBool or std_srvs/srv/Empty?\n",
    ),
    "action list": (0, "/count\n"),
    "param list": (0, "/talker:\n  pace\n  words\n"),
    "param get talker pace": (0, "Double value is: 0.5\n"),
    "param get talker pace --hide-type": (0, "0.5\n"),
    "param get /talker words": (0, "String values are: ['on', 'off']\n"),
    "interface show example_interfaces/action/Fibonacci": (
        0,
        "int32 order\n---\nint32[] sequence\n---\nint32[] sequence\n",
    ),
    "param get /talker pac": (1, "homebot: /talker: no parameter 'pac' is declared; did you mean pace?\n"),
    "node list": (0, "/listener\n/rosapi\n/rosbridge_websocket\n/talker\n"),
    "devices --type locks": (0, "no device offers locks now in Café\n"),
    "devices --type lihgts": (
        2,
        "homebot: 'lihgts' is not a device type, and no device was announced as one; …\n",
    ),
}
"""Commands with their exit codes, and what they print."""


def split(arguments: str) -> list[str]:
    """Return the words of *arguments*; what begins with a brace is one."""
    head, brace, rest = arguments.partition("{")
    return [*head.split(), *([brace + rest] if brace else [])]


@pytest.mark.parametrize("command", PRINTED)
def test_a_command_prints_what_it_should(homebot: Any, capsys: Text, command: str) -> None:
    code = run(homebot, *split(command))
    assert (code, "".join(capsys.readouterr())) == PRINTED[command]


def test_services_and_actions_are_listed_with_types_on_request(homebot: Any, capsys: Text) -> None:
    assert run(homebot, "service", "list", "-t") == 0
    out = capsys.readouterr().out
    assert f"/switch [{SWITCH}]\n" in out
    assert "/_action/" not in out
    assert run(homebot, "service", "list", "--all") == 0
    assert "/count/_action/send_goal\n" in capsys.readouterr().out
    assert run(homebot, "action", "list", "-t") == 0
    assert capsys.readouterr().out == "/count [example_interfaces/action/Fibonacci]\n"


def test_hidden_topics_and_types_are_listed_on_request(homebot: Any, capsys: Text) -> None:
    assert run(homebot, "topic", "list", "-t", "-a") == 0
    out = capsys.readouterr().out
    assert "/_hidden [std_msgs/msg/Int32]\n" in out
    assert "/chatter [std_msgs/msg/String]\n" in out


def test_what_is_of_a_robot_is_listed_with_where_it_is(homebot_with: Any, capsys: Text) -> None:
    def link(graph: Graph) -> Node:
        for info in (
            EndpointInfo(EntityKind.NODE, "/rosie/brain", "/rosie/brain"),
            EndpointInfo(EntityKind.PUBLISHER, "/rosie/brain", "/rosie/words", "std_msgs/msg/String"),
            EndpointInfo(EntityKind.SUBSCRIPTION, "/rosie/brain", "/hello", "std_msgs/msg/String"),
        ):
            graph.elsewhere.add(info, info)
        node = EndpointInfo(EntityKind.NODE, "/rosie/brain", "/rosie/brain")
        graph.add_endpoint(node, node)
        return Node(graph, "link")

    homebot = homebot_with(link, None)
    for arguments, line in (
        (("node", "list"), "/rosie/brain  (elsewhere)"),
        (("topic", "list", "-t"), "/rosie/words [std_msgs/msg/String]  (at /rosie/brain)"),
    ):
        assert run(homebot, *arguments) == 0
        lines = capsys.readouterr().out.splitlines()
        assert line in lines
        assert lines == sorted(lines)


def test_echo_prints_json(homebot: Any, capsys: Text) -> None:
    assert run(homebot, "topic", "echo", "--once", "--json", "/raw") == 0
    assert json.loads(capsys.readouterr().out)["payload"] == "b24="


def test_a_failure_that_a_response_reports_is_one_of_the_command(homebot: Any, capsys: Text) -> None:
    assert run(homebot, "service", "call", "--json", "switch", "std_srvs/SetBool", '{"data": false}') == 1
    out, err = capsys.readouterr()
    assert json.loads(out) == {"success": False, "message": "done"}
    assert json.loads(err) == {"error": "switch reported a failure: done"}
    assert run(homebot, "service", "call", "/rosapi/get_param", "{name: '/talker:volume'}") == 1
    assert "/rosapi/get_param reported a failure: " in capsys.readouterr().err


def test_a_device_without_a_name_is_asked_for_one(homebot: Any, capsys: Text) -> None:
    assert run(homebot, "show", "") == 1
    assert capsys.readouterr().err == "homebot: give the id or the name of a device; `homebot devices` lists all\n"


def test_devices_are_a_table_for_people(homebot: Any, capsys: Text) -> None:
    assert run(homebot, "devices", "--long") == 0
    head, row, count = capsys.readouterr().out.splitlines()
    assert count == "1 device in Café"
    assert head.split() == ["DEVICE", "NAME", "TYPE", "AVAILABILITY", "LAST", "SEEN", "GATEWAY", "COMMAND", "TOPIC"]
    assert row.split()[:4] == ["lights/lamp", "Lamp\\x1b[31m", "lights", "fresh"]
    assert row.split()[-3:] == ["ago", "mqtt", "home/lights/lamp/in"]


def test_devices_are_a_list_for_programs(homebot: Any, capsys: Text) -> None:
    assert run(homebot, "devices", "--type", "lights", "--json") == 0
    (found,) = json.loads(capsys.readouterr().out)
    assert (found["id"], found["name"], found["metadata"]) == ("lights/lamp", "Lamp\x1b[31m", {"room": "kitchen"})


def test_nobody_there_is_one_clear_sentence(capsys: Text) -> None:
    assert main(["topic", "list", "--door", "127.0.0.1:1"]) == 1
    assert capsys.readouterr().err == "homebot: no homebot is running on 127.0.0.1:1; start one with `homebot run`\n"


def test_a_locked_door_wants_its_token(
    locked_homebot: Any, capsys: Text, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(locked_homebot, "topic", "list") == 1
    assert "a valid token is needed" in capsys.readouterr().err
    token = tmp_path / "token"
    token.write_text("hunter2\n", encoding="utf-8")
    assert run(locked_homebot, "--token-file", str(token), "topic", "list") == 0
    monkeypatch.setenv("HOMEBOT_DOOR_TOKEN", "hunter2")
    assert run(locked_homebot, "topic", "list") == 0
    assert run(locked_homebot, "topic", "list", "--token-file", str(tmp_path / "absent")) == 1
    assert "cannot be read" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments",
    [
        ["service", "call", "/t", "std_srvs/Empty", "data"],
        ["service", "call", "/t", "std_srvs/Empty", "{data"],
        ["topic", "echo", "--timeout", "-1", "/t"],
        ["topic", "list", "--door", "nowhere"],
        ["topic", "list", "--door", "host:99999"],
    ],
)
def test_a_wrong_command_line_ends_with_code_2(arguments: list[str], capsys: Text) -> None:
    with pytest.raises(SystemExit) as caught:
        main(arguments)
    assert caught.value.code == 2
    assert "error: " in capsys.readouterr().err


def test_help_teaches_by_examples(capsys: Text) -> None:
    with pytest.raises(SystemExit) as caught:
        main(["service", "call", "--help"])
    assert caught.value.code == 0
    assert "homebot service call /getIndexData '{service_type: lights}'" in capsys.readouterr().out


def test_help_names_once_the_commands_that_connect_to_no_homebot(capsys: Text) -> None:
    (sentence,) = re.findall(r"All commands except (.*?) connect", _help_of(capsys), re.DOTALL)
    named = re.findall(r"`(\w+)`", sentence)
    assert {"join", "router", "run"} <= set(named)
    assert [one for one in named if "connection to a running homebot:" in _help_of(capsys, one)] == []


def _help_of(capsys: Text, *command: str) -> str:
    with pytest.raises(SystemExit):
        main([*command, "--help"])
    return capsys.readouterr().out


@pytest.mark.parametrize("command", ["devices", "doctor", "replay", "run"])
def test_help_fits_a_terminal_of_80_columns(capsys: Text, monkeypatch: pytest.MonkeyPatch, command: str) -> None:
    """The terminal broke the sentences below the examples within words; a long command stays whole, to be copied."""
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        main([command, "--help"])
    shown = capsys.readouterr().out.splitlines()
    assert [one for one in shown if len(one) > 80 and not one.startswith("  homebot ")] == []


@pytest.mark.parametrize("command", ["replay", "top", "why"])
def test_the_sentences_below_the_examples_are_not_indented(capsys: Text, command: str) -> None:
    with pytest.raises(SystemExit):
        main([command, "--help"])
    assert "\n    " not in capsys.readouterr().out.partition("\nexamples:")[2]


def _process(homebot: Any, *arguments: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-m", "homebot", *arguments]
    environment = os.environ | {"HOMEBOT_DOOR": homebot.door}
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def test_ctrl_c_ends_quietly(homebot: Any) -> None:
    with _process(homebot, "topic", "echo", "/ticks") as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "data: 1\n"
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=120)
    assert (process.returncode, errors) == (130, "")


def test_ctrl_c_is_heard_where_the_tests_run_in_the_background() -> None:
    """A shell has its background jobs ignore SIGINT, and so would whatever they start."""
    probe = "import signal; print(signal.getsignal(signal.SIGINT) is signal.SIG_IGN)"
    started = subprocess.run([sys.executable, "-c", probe], capture_output=True, text=True, check=True)
    assert started.stdout == "False\n"


def test_echo_waits_for_a_topic_that_does_not_exist_yet(homebot: Any) -> None:
    def speak() -> None:
        publisher = homebot.graph.get_node("/talker").create_publisher(String, "/later", qos_profile_latched)
        publisher.publish(String(data="now"))

    with _process(homebot, "topic", "echo", "--once", "--timeout", "10", "/later") as process:
        assert process.stderr is not None
        assert process.stderr.readline().startswith("homebot: no topic /later yet; waiting, Ctrl-C stops")
        homebot.do(speak)
        out, _ = process.communicate(timeout=120)
    assert out == "data: now\n---\n"


def test_a_closed_pipe_ends_quietly(homebot: Any) -> None:
    with _process(homebot, "topic", "echo", "/ticks") as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == "data: 1\n"
        process.stdout.close()
        assert process.stderr.read() == ""
        assert process.wait(40) == 0


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="only Linux has a disk that is always full")
def test_a_full_disk_is_one_clear_sentence(homebot: Any) -> None:
    command = [sys.executable, "-m", "homebot", "topic", "list", "--door", homebot.door]
    with Path("/dev/full").open("w") as full:
        ended = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (1, "homebot: No space left on device\n")


def test_output_that_is_closed_is_left_out(homebot: Any) -> None:
    command = [sys.executable, "-m", "homebot", "topic", "list", "--door", homebot.door]
    closed = ["sh", "-c", 'exec "$@" >&-', "sh", *command]
    ended = subprocess.run(closed, stderr=subprocess.PIPE, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (0, "")


def test_help_and_version_import_nothing_heavy() -> None:
    """They answer at once: no event loop, no WebSocket, no pydantic is loaded for them."""
    code = (
        "import sys, homebot.cli\n"
        "try: homebot.cli.main(['--version'])\n"
        "except SystemExit: pass\n"
        "print(sorted({'asyncio', 'anyio', 'pydantic', 'structlog', 'websockets'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout.splitlines()[-1] == "[]"


def test_json_for_other_programs_is_as_the_standard_library_writes_it() -> None:
    device = {"id": 'Kü"che\x9b\u2028\x7f', "empty": [], "of": {}, "x": [{"y": [1, 2.5, None, True]}, "客\U0001f4a1"]}
    assert json_text(device).lower() == json.dumps(device, indent=2).lower()
    assert list_text([json_text(device)] * 2).lower() == json.dumps([device] * 2, indent=2).lower()
    assert list_text([]) == "[]"
