"""Passwords and tokens of a running homebot: in no log line, no error, no traceback and no answer of a command."""

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.patience import PATIENCE
from tests.ports import reserve_port

pytestmark = pytest.mark.system

PASSWORD, TOKEN, IN_URL = "pass-0dd-word", "t0ken-0dd-w0rd", "url-0dd-word"
APP = """
from homebot.apps import App


class Crashing(App):
    async def run(self):
        password = open("password").read()
        token = open("token").read()
        raise RuntimeError("it fails with secrets at hand")
"""
CONFIG = """
[gateways.mqtt]
url = "mqtt://127.0.0.1:{closed}"
user = "robot"
password_file = "password"

[gateways.other]
class = "mqtt"
url = "mqtt://robot:{in_url}@127.0.0.1:{closed}"

[apps.crashing]
class = "crashing_app:Crashing"

[door]
port = {door}
token_file = "token"
"""
SETTINGS = {name: value for name, value in os.environ.items() if not name.startswith("HOMEBOT_")}


def command(folder: Path, *arguments: str) -> str:
    done = subprocess.run(
        [sys.executable, "-m", "homebot", *arguments],
        cwd=folder,
        env={**SETTINGS, "HOMEBOT_DATA": str(folder / "data")},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    return done.stdout + done.stderr


@pytest.mark.parametrize("form", ["console", "json"])
def test_no_secret_is_told_by_anything(tmp_path: Path, form: str) -> None:
    door = reserve_port()
    (tmp_path / "crashing_app.py").write_text(APP)
    for name, secret in (("password", PASSWORD), ("token", TOKEN)):
        (tmp_path / name).touch(mode=0o600)
        (tmp_path / name).write_text(f"{secret}\n")
    text = CONFIG.format(closed=reserve_port(), door=door, in_url=IN_URL)
    (tmp_path / "homebot.toml").write_text(text)
    (tmp_path / "broken.toml").write_text(text + "max_clients = 0\n")
    log = tmp_path / "log"
    with log.open("w") as out:
        running = subprocess.Popen(
            [sys.executable, "-m", "homebot", "run", "--log-format", form, "--for", f"{10 * PATIENCE:g}"],
            cwd=tmp_path,
            env={**SETTINGS, "HOMEBOT_DATA": str(tmp_path / "data")},
            stdout=out,
            stderr=out,
        )
    try:
        until = time.monotonic() + PATIENCE
        while "it fails with secrets at hand" not in log.read_text() and time.monotonic() < until:
            time.sleep(0.1)
        at = ("--door", f"127.0.0.1:{door}")
        told = (
            []
            if form == "json"
            else [
                command(tmp_path, "config", "check"),
                command(tmp_path, "config", "check", "--config", "broken.toml"),
                command(tmp_path, "doctor", *at),
                command(tmp_path, "param", "list", "/gateway/mqtt", *at),
                command(tmp_path, "run", "--mqtt", f"mqtt://robot:{IN_URL}@127.0.0.1:1:2"),
            ]
        )
    finally:
        running.terminate()
        running.wait(PATIENCE)
    written = log.read_text()
    assert "it fails with secrets at hand" in written
    assert "Traceback" in written
    for secret in (PASSWORD, TOKEN, IN_URL):
        assert not [one for one in (written, *told) if secret in one]
