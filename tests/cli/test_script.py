"""``homebot.run``: a homebot that a script starts."""

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from homebot import App, UsageError, run

HEAD = """\
import asyncio, os, signal
from homebot import App, run

class Greeter(App):
    async def run(self):
        print("hello from", self.node.full_name, flush=True)
        os.kill(os.getpid(), signal.SIGINT)  # Ctrl-C
        await asyncio.Event().wait()
"""


def script(tmp_path: Path, text: str) -> subprocess.CompletedProcess[str]:
    (tmp_path / "script.py").write_text(HEAD + text)
    return subprocess.run(
        [sys.executable, "script.py"],
        cwd=tmp_path,
        env={**os.environ, "HOMEBOT_DOOR": "127.0.0.1:0"},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


def test_an_app_of_a_script_runs_until_ctrl_c_and_the_script_goes_on(tmp_path: Path) -> None:
    done = script(tmp_path, 'print("ended with", run(Greeter))')
    assert done.stdout.splitlines() == ["hello from /greeter", "ended with 0"]
    assert "the app greeter runs" in done.stderr or "stopping" in done.stderr
    assert "Traceback" not in done.stderr
    assert done.returncode == 0


def test_the_configuration_in_the_folder_counts(tmp_path: Path) -> None:
    """As for ``homebot run``; what is wrong in it is an error that the script may catch."""
    (tmp_path / "homebot.toml").write_text("[nonsense]\n")
    text = """
from homebot import ConfigError
try:
    run(Greeter)
except ConfigError as exc:
    print(exc.source, exc.key)
"""
    done = script(tmp_path, text)
    assert (done.stdout, done.stderr) == ("homebot.toml nonsense\n", "")


def test_a_log_that_the_script_has_set_up_is_left_alone(tmp_path: Path) -> None:
    setup = "import structlog; structlog.configure(processors=[lambda *line: f\"mine: {line[2]['event']}\"])\n"
    done = script(tmp_path, f"{setup}run(Greeter)")
    assert "mine: runtime.stopping" in done.stdout
    assert done.stderr == ""


def local_app() -> type[App]:
    class Local(App):
        async def run(self) -> None: ...

    return Local


def test_an_app_inside_a_function_is_refused_in_words() -> None:
    """A crashed app is made anew from its name."""
    with pytest.raises(UsageError, match=r"Local is not found in \S+; define it at the top level there"):
        run(local_app())


async def test_where_an_event_loop_runs_it_is_refused() -> None:
    with pytest.raises(UsageError, match="async with Runtime"):
        run()


def test_in_another_thread_it_is_refused() -> None:
    errors: list[Exception] = []

    def call() -> None:
        try:
            run()
        except UsageError as exc:
            errors.append(exc)

    thread = threading.Thread(target=call)
    thread.start()
    thread.join(10)
    assert "main thread" in str(errors[0])
