"""What the shell completes, as the shell itself finds it."""

import json
import os
import pty
import select
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from anyio import to_thread
from tests.patience import PATIENCE
from tests.whole_house import WHOLE_HOUSE

from homebot.cli.main import main
from homebot.testing import house_of

pytestmark = pytest.mark.skipif(shutil.which("bash") is None, reason="bash is not installed")

# What the shell does where somebody presses Tab, after having asked itself which function that is.
_TAB = """
source "$1"; shift
line=$(complete -p homebot); line=${line#*-F }; function=${line%% *}
COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1))
$function
printf '%s\\n' "${COMPREPLY[@]}"
"""


@pytest.fixture(scope="module")
def script(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The script for bash, as the command prints it."""
    file = tmp_path_factory.mktemp("completion") / "homebot.bash"
    command = [sys.executable, "-m", "homebot", "--print-completion", "bash"]
    file.write_bytes(subprocess.run(command, capture_output=True, check=True).stdout)
    return file


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("homebot to", {"token", "top", "topic"}),
        ("homebot topic ", {"echo", "list"}),
        ("homebot --door localhost:9090 ser", {"service"}),
        ("homebot devices --js", {"--json"}),
        ("homebot run --log-format ", {"console", "json"}),
        ("homebot --print-completion ", {"bash", "fish", "zsh"}),
        ("homebot run --config ho", {"home.toml"}),
        ("homebot import ho", {"home.toml"}),
        ("homebot devices --td ", {"things"}),
        ("homebot show ", {""}),
        ("homebot do lamp o", {"on", "off", "open"}),
        ("homebot do lamp on --js", {"--json"}),
    ],
)
def test_bash_completes_commands_options_choices_and_files(
    script: Path, tmp_path: Path, line: str, found: set[str]
) -> None:
    (tmp_path / "home.toml").touch()
    (tmp_path / "things").mkdir()
    words = ["bash", "--norc", "-c", _TAB, "bash", str(script), *line.split(" ")]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=True, timeout=120)
    assert (set(done.stdout.splitlines()), done.stderr) == (found, "")


def test_the_tab_key_completes_a_command(script: Path) -> None:
    """In a shell that somebody types into."""
    terminal, stdio = pty.openpty()
    environment = os.environ | {"PS1": "ready> ", "TERM": "dumb"}
    with subprocess.Popen(["bash", "--norc", "-i"], stdin=stdio, stdout=stdio, stderr=stdio, env=environment):
        os.close(stdio)
        _read_until(terminal, b"ready> ")
        os.write(terminal, f"source {script}\n".encode())
        _read_until(terminal, b"ready> ")
        os.write(terminal, b"homebot serv\t")
        _read_until(terminal, b"homebot service ")
        os.write(terminal, b"ca\t")
        _read_until(terminal, b"call ")
        os.write(terminal, b"\x15exit\n")
    os.close(terminal)


def _read_until(terminal: int, end: bytes) -> bytes:
    shown = b""
    until = time.monotonic() + PATIENCE
    while end not in shown:
        ready, _, _ = select.select([terminal], [], [], max(0.0, until - time.monotonic()))
        assert ready, f"only this was shown: {shown!r}"
        shown += os.read(terminal, 1000)
    return shown


NAMES = ("Hall lamp", "Hall light 2", "Küche", "Wohnzimmer's Lampe", "$(touch spoilt)")


@asynccontextmanager
async def lamps() -> AsyncIterator[dict[str, str]]:
    """Let lamps announce themselves; yield the environment in which commands reach their homebot."""
    async with house_of() as homebot, homebot.client("lamps") as retaining:
        for number, name in enumerate(NAMES):
            light = {"name": None, "unique_id": f"id{number}", "command_topic": f"x/{number}/set", "state_topic": "x"}
            text = json.dumps(light | {"device": {"identifiers": [f"id{number}"], "name": name}})
            await homebot.says(f"homeassistant/light/id{number}/config", text)
        await retaining.publish("x", b"ON", qos=1, retain=True)  # homebot subscribes to it when it knows the lamps
        for name in NAMES:
            await homebot.becomes(name, on=True)
        assert homebot.runtime.rosbridge is not None
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        door = f"127.0.0.1:{homebot.runtime.rosbridge.port}"
        yield os.environ | {"HOMEBOT_DOOR": door, "PATH": path, "LC_ALL": "C.UTF-8"}


async def completed(words: list[str], environment: dict[str, str], folder: Path) -> str:
    """Return what a program prints that completes, asked again as long as the computer is too busy for it."""
    found = ""
    with anyio.move_on_after(PATIENCE):
        while not found.strip():
            done = await anyio.run_process(words, env=environment, cwd=folder)
            assert done.stderr == b""
            found = done.stdout.decode()
    return found


@WHOLE_HOUSE
async def test_bash_completes_names_of_devices_quoted(script: Path, tmp_path: Path) -> None:
    async with lamps() as environment:
        for line, found in (
            (("why", "Hall"), {r"Hall\ lamp", r"Hall\ light\ 2"}),
            (("do", r"Hall\ la"), {r"Hall\ lamp"}),
            (("show", '"Hall la'), {"Hall lamp"}),
            (("show", r"hall\ la"), {r"Hall\ lamp"}),
            (("show", "K"), {"Küche"}),
            (("show", "W"), {r"Wohnzimmer\'s\ Lampe"}),
            (("show", r"\$"), {r"\$\(touch\ spoilt\)"}),
            (("show", '"$'), {r"\$(touch spoilt)"}),
            (("show", "'W"), {r"Wohnzimmer'\''s Lampe"}),
        ):
            words = ["bash", "--norc", "-c", _TAB, "bash", str(script), "homebot", *line]
            assert set((await completed(words, environment, tmp_path)).splitlines()) == found
        assert list(tmp_path.iterdir()) == []


@WHOLE_HOUSE
async def test_without_a_homebot_or_with_one_that_is_silent_nothing_is_completed(
    tmp_path: Path,
) -> None:
    async with lamps() as environment:
        words = [sys.executable, "-m", "homebot", "--complete-devices"]
        assert await completed([*words, "show", "K"], environment, tmp_path) == "Küche\n"
        with socket.create_server(("127.0.0.1", 0)) as silent:
            for door in ("localhost:1", f"localhost:{silent.getsockname()[1]}", "no address"):
                done = await anyio.run_process([*words, "--door", door, "show", "K"], env=environment)
                assert (done.stdout, done.stderr) == (b"", b"")


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_the_scripts_of_other_shells_ask_for_devices(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["--print-completion", shell])
    assert " --complete-devices " in capsys.readouterr().out


@WHOLE_HOUSE
@pytest.mark.skipif(shutil.which("fish") is None, reason="fish is not installed")
async def test_fish_completes_names_of_devices(tmp_path: Path) -> None:
    async with lamps() as environment:
        program = "homebot --print-completion fish | source; complete --do-complete 'homebot show Hall'"
        found = await completed(["fish", "--no-config", "-c", program], environment, tmp_path)
        assert {one.partition("\t")[0] for one in found.splitlines()} == {"Hall lamp", "Hall light 2"}


@WHOLE_HOUSE
@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
async def test_the_tab_key_of_zsh_completes_names_of_devices_quoted(tmp_path: Path) -> None:
    """The shell prints the words of the completed line, as a command gets them."""
    script = 'PROMPT="rea""dy> "; autoload -Uz compinit; compinit -D; eval "$(homebot --print-completion zsh)"\n'

    def press_tab(environment: dict[str, str]) -> None:
        terminal, stdio = pty.openpty()
        zsh = subprocess.Popen(["zsh", "-f"], stdin=stdio, stdout=stdio, stderr=stdio, env=environment, cwd=tmp_path)
        os.close(stdio)
        until = time.monotonic() + PATIENCE
        try:
            os.write(terminal, script.encode())
            _read_until(terminal, b"ready> ")
            for typed, name in (
                ("K", "Küche"),
                (r"hall\ la", "Hall lamp"),
                ("W", "Wohnzimmer's Lampe"),
                (r"\$", "$(touch spoilt)"),
            ):
                shown, line = b"", f"homebot show {typed}\t\x01printf '<%s>' \x05 end\n".encode()
                while f"<show><{name}>".encode() not in shown:  # again if the computer is too busy for it
                    assert time.monotonic() < until, shown
                    os.write(terminal, line)
                    shown = _read_until(terminal, b"end>")
        finally:
            zsh.kill()
            zsh.wait()
            os.close(terminal)

    async with lamps() as environment:
        await to_thread.run_sync(press_tab, environment)
    assert list(tmp_path.iterdir()) == []
