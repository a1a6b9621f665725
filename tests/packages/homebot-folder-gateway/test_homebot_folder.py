"""The tests of the gateway, in a homebot that has no other one."""

from __future__ import annotations

import os
import sys
from importlib.metadata import entry_points
from pathlib import Path

import anyio
import pytest

from homebot import App, ConfigError, Light, Runtime, parse_config
from homebot.testing import TestHouse


@pytest.fixture
def homebot_config(tmp_path: Path) -> dict[str, object]:
    return {"gateways": {"folder": {"folder": str(tmp_path)}}}


async def content(file: Path, expected: str) -> None:
    """Wait until *file* holds what the test expects."""
    with anyio.fail_after(60):
        while not file.exists() or file.read_text() != expected:  # noqa: ASYNC110 - a file tells nobody
            await anyio.sleep(0.02)


class Dawn(App):
    """Turns on every lamp that is off."""

    async def run(self) -> None:
        async for change in self.devices.follow(Light, on=False):
            if change.kind == "appeared":
                await change.handle.turn_on()


def test_the_package_is_installed() -> None:
    """Else nothing here would be shown of entry points."""
    assert "folder" in entry_points(group="homebot.gateways").names


@pytest.mark.homebot.with_args(Dawn)
async def test_an_app_finds_the_lamp_by_its_state_and_turns_it_on(homebot: TestHouse, tmp_path: Path) -> None:
    (tmp_path / "hall.lamp").write_text("off")
    await content(tmp_path / "hall.set", "on")


@pytest.mark.homebot("light_service")
async def test_the_light_service_turns_the_lamp_off(homebot: TestHouse, tmp_path: Path) -> None:
    (tmp_path / "hall.lamp").write_text("on")
    await content(tmp_path / "hall.set", "off")


async def printed(homebot: TestHouse, *command: str, until: str) -> str:
    """Return what the command line prints, once that holds *until*."""
    assert homebot.runtime.rosbridge is not None
    door = {"HOMEBOT_DOOR": f"127.0.0.1:{homebot.runtime.rosbridge.port}"}
    with anyio.fail_after(60):
        while True:
            program = [sys.executable, "-m", "homebot", *command]
            done = await anyio.run_process(program, env={**os.environ, **door}, check=False)
            if until in (text := done.stdout.decode()):
                return text


async def test_the_command_line_lists_the_lamp_with_its_state(homebot: TestHouse, tmp_path: Path) -> None:
    (tmp_path / "hall.lamp").write_text("on")
    lines = (await printed(homebot, "devices", "--long", until="hall")).splitlines()
    words = lines[1].split()
    assert (words[1:3], "folder" in words) == (["lights", "on"], True)


async def test_a_lamp_whose_file_is_deleted_is_removed(homebot: TestHouse, tmp_path: Path) -> None:
    lamp = tmp_path / "hall.lamp"
    lamp.write_text("on")
    await printed(homebot, "devices", until="hall")
    lamp.unlink()
    await printed(homebot, "devices", until="no device")


async def test_a_folder_that_goes_missing_makes_the_gateway_unavailable(homebot: TestHouse, tmp_path: Path) -> None:
    (tmp_path / "hall.lamp").write_text("on")
    await printed(homebot, "devices", until="hall")
    tmp_path.rename(tmp_path.with_name("unplugged"))
    await printed(homebot, "doctor", until=f"{tmp_path} does not exist")
    assert "hall" in await printed(homebot, "devices", until="DEVICE")


def test_a_folder_that_does_not_exist_is_an_error_that_names_the_key(tmp_path: Path) -> None:
    config = parse_config({"gateways": {"folder": {"folder": str(tmp_path / "nowhere")}}}, "test")
    with pytest.raises(ConfigError, match=r"gateways\.folder: folder '.*nowhere' does not exist"):
        Runtime(config)
