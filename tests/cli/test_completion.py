"""What the shell completes, as the shell itself finds it."""

from __future__ import annotations

import os
import pty
import select
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.patience import PATIENCE

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
        ("homebot to", {"token", "topic"}),
        ("homebot topic ", {"echo", "find", "hz", "info", "list", "pub", "type"}),
        ("homebot --door localhost:9090 ser", {"service"}),
        ("homebot devices --js", {"--json"}),
        ("homebot run --log-format ", {"console", "json"}),
        ("homebot --print-completion ", {"bash", "zsh"}),
        ("homebot run --config ho", {"home.toml"}),
        ("homebot import ho", {"home.toml"}),
        ("homebot devices --td ", {"things"}),
        ("homebot show ", {""}),
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


def _read_until(terminal: int, end: bytes) -> None:
    shown = b""
    until = time.monotonic() + PATIENCE
    while end not in shown:
        ready, _, _ = select.select([terminal], [], [], max(0.0, until - time.monotonic()))
        assert ready, f"only this was shown: {shown!r}"
        shown += os.read(terminal, 1000)


@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
def test_zsh_reads_its_script() -> None:
    command = [sys.executable, "-m", "homebot", "--print-completion", "zsh"]
    script = subprocess.run(command, capture_output=True, check=True).stdout
    program = 'autoload -Uz compinit && compinit -D; eval "$(cat)"; print $_comps[homebot]'
    done = subprocess.run(["zsh", "-f", "-c", program], input=script, capture_output=True, check=True, timeout=120)
    assert (done.stdout.strip(), done.stderr) == (b"_shtab_homebot", b"")
