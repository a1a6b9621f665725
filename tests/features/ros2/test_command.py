"""``homebot router``: a process of its own that lets in the robots of homebot.toml, and the homebot beside it."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
import zenoh
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import log_in, secret_of, write_tokens
from tests.shell import homebot_in
from tests.system.attack_probe import until

from homebot.cli import main

pytestmark = pytest.mark.slow

GUIDE = (Path(__file__).parents[3] / "docs" / "robots.md").read_text("utf-8")
WORDS = "0/{}/words/T/H"


class Router:
    """A router in a process, with the first line that it printed."""

    def __init__(self, process: subprocess.Popen[str], line: str) -> None:
        self.process, self.line = process, line

    def next_line(self) -> str:
        assert self.process.stderr is not None
        return self.process.stderr.readline()


@pytest.fixture(autouse=True)
def _data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path / "data"))
    monkeypatch.chdir(tmp_path)


def write_configuration(address: str, *robots: str, ros: str = "") -> None:
    imports = ", ".join(f'{one} = ["/{one}/**"]' for one in ("rosie", "bob"))
    tokens = write_tokens(Path(), *robots)
    ros = f'[ros]\nlisten = "{address}"\nimport = {{{imports}}}\n{ros}'
    Path("homebot.toml").write_text(f'[home]\nname = "villa"\n{tokens}{ros}')


@contextmanager
def router() -> Iterator[Router]:
    """Run the router until the end of the block, which it may have ended itself; it must end well."""
    command = [sys.executable, "-m", "homebot", "router"]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stderr is not None
            yield Router(process, process.stderr.readline())
        finally:
            process.terminate()
            _, rest = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0, rest
    assert secret_of("") not in rest


def entered(address: str, robot: str) -> zenoh.Session:
    return log_in(address, robot, patience=PATIENCE)


def heard(sender: zenoh.Session, reader: zenoh.Session, robot: str) -> bool:
    """Return once what *sender* says as *robot* has come to *reader*."""
    got: list[bytes] = []
    key = WORDS.format(robot)
    with reader.declare_subscriber(key, lambda sample: got.append(sample.payload.to_bytes())):

        def say() -> bool | None:
            sender.put(key, b"hello")
            return bool(got) or None

        return bool(until(say, PATIENCE))


def test_it_says_where_it_listens_and_who_may_log_in_and_ends_within_a_second_of_sigterm() -> None:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    write_configuration(address, "rosie", "bob")
    with router() as running:
        assert f"listening on {address}; may log in: owner, rosie, bob" in running.line
        with entered(address, "rosie") as one, entered(address, "rosie") as other:
            assert heard(one, other, "rosie"), "programs of one robot hear each other"
        began = time.monotonic()
        running.process.send_signal(signal.SIGTERM)
        running.process.wait(PATIENCE)
        assert time.monotonic() - began < 1.0


def test_at_sighup_a_token_that_was_revoked_lets_nobody_in() -> None:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    write_configuration(address, "rosie", "bob")
    with router() as running:
        with entered(address, "rosie"):
            pass
        write_configuration(address, "bob")
        running.process.send_signal(signal.SIGHUP)
        assert "may log in: owner, bob" in running.next_line()
        with entered(address, "bob"):
            pass
        with pytest.raises(zenoh.ZError, match="Unable to connect"):
            log_in(address, "rosie")
        Path("homebot.toml").write_text("[ros]\nlisten = 3\n")
        running.process.send_signal(signal.SIGHUP)
        assert "nothing was reloaded: homebot.toml: ros.listen" in running.next_line()
        with entered(address, "bob"):
            pass


def test_homebot_beside_it_logs_in_as_the_owner() -> None:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    write_configuration(address, "rosie", "bob", ros=f'connect = ["{address}"]\n')
    with router(), homebot_in(Path(), until=("is running",)), entered(address, "rosie") as rosie:

        def sees_homebot() -> bool | None:
            replies = rosie.liveliness().get("@ros2_lv/0/*/*/*/NN/**", timeout=PATIENCE)
            return any(str(one.ok.key_expr).endswith("/%/%/ros2") for one in replies if one.ok is not None) or None

        assert until(sees_homebot, PATIENCE)


def test_the_configuration_of_a_program_in_the_guide_lets_it_in_with_the_certificate() -> None:
    address = f"tls/127.0.0.1:{reserve_port()}"
    assert main(["router", "--certificate", "villa.lan"]) == 0
    write_configuration(address, "rosie", ros='cert_file = "router.crt"\nkey_file = "router.key"\n')
    (config,) = re.findall(r"```json5\n(.*?)```", GUIDE, re.DOTALL)
    config = (
        config.replace("tcp/127.0.0.1:7447", address).replace("TOKEN", secret_of("rosie")).replace("// link", "link")
    )
    with router():
        with zenoh.open(zenoh.Config.from_json5(config)):
            pass
        with pytest.raises(zenoh.ZError, match="Unable to connect"):
            zenoh.open(zenoh.Config.from_json5(config.replace("router.crt", os.devnull)))


@pytest.mark.parametrize(
    ("ros", "problem"),
    [
        ("", 'homebot.toml has no listen in [ros]; write listen = "tcp/127.0.0.1:7447"'),
        ('listen = "tcp/0.0.0.0:7447"\n', "could be changed on its way; use tls/"),
        ('listen = "tls/0.0.0.0:7447"\n', "make them: homebot router --certificate"),
    ],
)
def test_what_cannot_be_served_is_one_clear_sentence(
    capsys: pytest.CaptureFixture[str], ros: str, problem: str
) -> None:
    Path("homebot.toml").write_text(f"[ros]\n{ros}")
    assert main(["router"]) == 1
    err = capsys.readouterr().err
    assert problem in err
    assert err.count("\n") == 1


def test_a_certificate_comes_with_the_lines_for_the_configuration(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["router", "--certificate"]) == 0
    out = capsys.readouterr().out
    assert 'listen = "tls/0.0.0.0:7447"\ncert_file = "router.crt"\nkey_file = "router.key"\n' in out
    assert Path("router.key").read_text() not in out
    assert main(["router", "--certificate"]) == 1
    assert "router.crt is there; remove it" in capsys.readouterr().err
