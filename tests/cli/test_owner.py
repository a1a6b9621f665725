"""The owner at the shell: the command line finds the token in the data folder, and nobody types it."""

import asyncio
from pathlib import Path
from typing import Any

import pytest
from structlog.testing import capture_logs

from homebot.cli import main
from homebot.config import parse_config
from homebot.runtime import Runtime
from homebot.support.owner_token import OWNER_FILE

pytestmark = pytest.mark.slow

FORGET = ["service", "call", "/discovery/forget", "{device: nothing}"]


async def run(runtime: Runtime, *words: str) -> int:
    assert runtime.rosbridge is not None
    return await asyncio.to_thread(main, [*words, "--door", f"127.0.0.1:{runtime.rosbridge.port}"])


def real_home(folder: Path, **door: Any) -> Runtime:
    config = parse_config({"door": {"port": 0, **door}}, "test", folder)
    return Runtime(config, owner_file=folder / OWNER_FILE)


@pytest.mark.parametrize("door", [{}, {"token": "panel"}, {"scope": ["read"]}])
async def test_a_person_at_the_shell_manages_homebot_and_types_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], door: dict[str, Any]
) -> None:
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path))
    async with real_home(tmp_path, **door) as runtime:
        await run(runtime, *FORGET)
    assert "there is no device 'nothing'" in capsys.readouterr().err


async def test_another_user_reads_and_hears_where_the_owners_token_is(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """So does a program that has the data of another homebot."""
    monkeypatch.setenv("HOMEBOT_DATA", str(tmp_path / "mine"))
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / OWNER_FILE).write_text("the token of another homebot\n")
    async with real_home(tmp_path) as runtime:
        assert await run(runtime, "devices") == 0
        assert await run(runtime, *FORGET) == 1
        told = capsys.readouterr().err
        assert f"use the owner's token, which the user of homebot finds in {tmp_path / OWNER_FILE}" in told
        assert await run(runtime, *FORGET, "--token-file", str(tmp_path / OWNER_FILE)) == 1
        assert "there is no device 'nothing'" in capsys.readouterr().err


async def test_without_a_folder_for_it_homebot_runs_and_says_what_is_missing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with capture_logs() as logs:
        async with Runtime(
            parse_config({"door": {"port": 0}}, "test", tmp_path), owner_file=tmp_path / "file" / OWNER_FILE
        ) as runtime:
            assert await run(runtime, "devices") == 0
    (warning,) = [one["message"] for one in logs if one["event"] == "runtime.no_owner_token"]
    assert warning.startswith("the command line can only read and give harmless commands: ")
    assert warning.endswith("name another folder in HOMEBOT_DATA")
