"""A reload of a file that lacks something: it may have been read while it was saved, so it takes no limit away."""

import os
from collections.abc import Callable
from pathlib import Path

import pytest

from homebot.cli.commands.run import _config
from homebot.cli.main import make_parser
from homebot.config import Config, parse_config
from homebot.devices.app_messages import Reload
from homebot.devices.health import GetHealth
from homebot.devices.names import RELOAD, RUNTIME_HEALTH
from homebot.errors import ConfigError, UsageError
from homebot.graph import Node
from homebot.runtime import Runtime
from homebot.runtime.reload import lost_keys
from homebot.support.file_access import read_secret
from homebot.support.toml_file import parse_toml, read_toml

COMPLETE = """\
[discovery]
persist = false
[door]
scope = []
[door.tokens.panel]
token_file = "panel.token"
scope = ["read", "act: light in hall"]
[door.tokens.hub]
token_file = "hub.token"
scope = ["read"]
[apps.light_service]
act = []
[places.rooms.hall]
floor = "Downstairs"
[places.devices.lamp]
tags = ["late"]
room = "hall"
[[control.quiet_hours]]
start = "22:00"
end = "06:00"
commands = ["turn off light in hall"]
[[control.quiet_hours]]
start = "12:00"
end = "13:00"
commands = ["turn off light"]
[control]
timeout = 8
rate_limit = {changes = 10, seconds = 60}
[control.presence_guard.doors]
hall = ["contact"]
[control.presence_guard]
absent_after = 1800
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    for name, text in (("homebot.toml", COMPLETE), ("panel.token", "panel-0123456789\n"), ("hub.token", "hub-012\n")):
        path = tmp_path / name
        path.touch(0o600)
        path.write_text(text)
    return tmp_path / "homebot.toml"


@pytest.fixture
def read(file: Path) -> Callable[[], Config]:
    """What ``homebot run --config`` calls at SIGHUP."""
    options = make_parser(["run"]).parse_args(["run", "--config", str(file)])
    return lambda: _config(options)


def parse(text: str, file: Path) -> Config:
    return parse_config(parse_toml(text, str(file)), str(file), file.parent)


def in_force(runtime: Runtime) -> list[object]:
    plan = runtime._plan
    rights = plan.door.rights(runtime._local_rights)
    policies = plan.control and plan.control.model_dump(exclude={"timeout"})
    return [rights, plan.door.all_tokens(), plan.grants.now, policies, plan.places]


async def test_a_file_cut_anywhere_changes_nothing_that_limits_somebody(file: Path, read: Callable[[], Config]) -> None:
    """Programs save by emptying a file and then writing it."""
    async with Runtime(parse(COMPLETE, file), with_door=False) as runtime:
        before = in_force(runtime)
        for size in range(len(COMPLETE)):
            file.write_text(COMPLETE[:size])
            await runtime.reload(read)
            assert in_force(runtime) == before, COMPLETE[:size]


@pytest.mark.parametrize("name", ["panel.token", "hub.token"])
async def test_a_token_cut_anywhere_is_no_token(file: Path, read: Callable[[], Config], name: str) -> None:
    token = file.with_name(name)
    complete = token.read_text()
    async with Runtime(parse(COMPLETE, file), with_door=False) as runtime:
        before = in_force(runtime)
        for size in range(len(complete)):
            token.write_text(complete[:size])
            await runtime.reload(read)
            assert in_force(runtime) == before
        token.write_text("another-0123456789\n")
        assert (await runtime.reload(read)).success
        assert in_force(runtime) != before


@pytest.mark.parametrize(
    ("old", "new", "lost"),
    [
        ("[door]\ntoken = 'a'", "", "door.token"),
        ("[door]\ntoken_file = 'a'", "[door.tokens.a]\ntoken_file = 'a'\nscope = []", "door.token_file"),
        ("[door]\ntoken_file = 'a'", "[door]\ntoken = 'a'", ""),
        ("[door]\nport = 1", "", ""),
        ("[door.tokens.a]\nx = 1\n[door.tokens.b]", "[door.tokens.b]\ny = 1", ""),
        ("[door.tokens.a]\nx = 1", "[door]\nport = 1", "[door.tokens]"),
        (
            "[door.tokens.a]\ntoken_file = 'a'\nuntil = '2099-12-31'",
            "[door.tokens.a]\ntoken_file = 'a'",
            "door.tokens.a.until",
        ),
        ("[door]\ntoken = 'a'\n[door.tokens.a]\nx = 1", "[door]\ntoken = 'a'", ""),
        ("[apps.a]\nact = 'light'\nroom = 'hall'", "[apps.a]\nact = 'lock'", ""),
        ("[apps.a]\nact = 'light'", "[apps.a]\nroom = 'hall'", "apps.a.act"),
        ("[apps.a]\nact = 'light'", "", "[apps]"),
        ("[control]\npresence_guard = true", "[control]", "control.presence_guard"),
        ("[control]\npresence_guard = true", "[control]\npresence_guard = false", ""),
        ("[control]\npresence_guard = {absent_after = 1}", "[control]\npresence_guard = false", ""),
        ("[control.presence_guard]\nabsent_after = 1", "[control.presence_guard]", "[control.presence_guard]"),
        ("[control]\napprovals = false\ntimeout = 9", "[control]", ""),
        (
            "[[control.quiet_hours]]\na = 1\n[[control.quiet_hours]]\na = 2",
            "[[control.quiet_hours]]\na = 3",
            "[control",
        ),
        ("[[control.quiet_hours]]\na = 1\nb = 1", "[[control.quiet_hours]]\na = 3", "control.quiet_hours.b"),
        ("[[control.quiet_hours]]\na = 1", "[control]\nquiet_hours = []", ""),
        ("[places.devices.a]\nroom = 'b'\n[places.devices.b]\nroom = 'b'", "[places.devices.b]\nroom = 'b'", "[places"),
        ("[places.devices.a]\nroom = 'b'", "[places.devices.a]\nroom = 'c'\ntags = ['d']", ""),
        ("[places.devices.a]\ntags = ['b']\n[places.devices.b]", "[places.devices.a]\nx = 1\n[places.devices.b]", ""),
        ("[places.devices.a]\ntags = ['b']", "[places.devices.a]\nroom = 'c'", "places.devices.a.tags"),
        ("[gateways.ble]\nadapter = 'a'\n[gateways.nfc]", "[gateways.nfc]", "[gateways.ble]"),
        ("[gateways.ble]\nadapter = 'a'", "[gateways.ble]\nact = true", ""),
        ("[notify]\nurls = ['a']", "", "[notify]"),
    ],
)
def test_what_is_lost_is_named(old: str, new: str, lost: str) -> None:
    """Changed values, and one of several tokens, are the owner's decision."""
    before, after = (parse_config(parse_toml(text, "homebot.toml"), "homebot.toml") for text in (old, new))
    named = ", ".join(lost_keys(before, after))
    assert named.startswith(lost) if lost else named == ""


async def test_a_removal_that_is_meant_needs_a_word_and_a_refusal_is_a_problem_until_then(
    file: Path, read: Callable[[], Config]
) -> None:
    running = Runtime(parse(COMPLETE, file), with_door=False, read_config=read)
    async with running as runtime, Node(runtime.graph, "owner") as node:
        reload, health = node.create_client(Reload, RELOAD), node.create_client(GetHealth, RUNTIME_HEALTH)
        file.write_text(COMPLETE.partition("[control.presence_guard.doors]")[0])
        refused = await reload.call(Reload.Request(allow_removal=False))
        expected = f"{file} lacks what it had before: [control.presence_guard]; save it whole"
        assert (refused.success, refused.message[: len(expected)]) == (False, expected)
        (trouble,) = (await health.call(GetHealth.Request())).troubles
        assert trouble.startswith(f"the last reload was refused: {expected}")
        done = await reload.call(Reload.Request(allow_removal=True))
        assert done == Reload.Response(success=True, message="tokens, rights, policies and places were reloaded")
        assert not (await health.call(GetHealth.Request())).troubles
        assert (await reload.call(Reload.Request(allow_removal=False))).success  # the new one is what counts


@pytest.mark.parametrize("make", [os.mkfifo, lambda path: path.symlink_to("/dev/zero"), Path.mkdir])
def test_what_is_no_file_is_refused_at_once(tmp_path: Path, make: Callable[[Path], None]) -> None:
    """A pipe waited for its other end, and an endless file filled the memory."""
    make(tmp_path / "homebot.toml")
    with pytest.raises(ConfigError, match=r"is no regular file|Is a directory"):
        read_toml(tmp_path / "homebot.toml")


def test_a_huge_file_is_refused(tmp_path: Path) -> None:
    with (tmp_path / "homebot.toml").open("wb") as file:
        file.truncate(2_100_000_000)
    with pytest.raises(ConfigError, match="is larger than 4 MiB"):
        read_toml(tmp_path / "homebot.toml")


def test_a_secret_in_a_pipe_that_nobody_writes_is_empty(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe", 0o600)
    with pytest.raises(UsageError, match="is empty"):
        read_secret(tmp_path / "pipe")
    reader, writer = os.pipe()
    try:
        os.write(writer, b"secret\n")
        assert read_secret(Path(f"/dev/fd/{reader}")) == "secret"
    finally:
        os.close(reader)
        os.close(writer)
