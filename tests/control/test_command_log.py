"""Lines of the log for commands and for changes that no command explains, in virtual time."""

import re

import anyio
import pytest
from structlog.testing import capture_logs
from tests.control.conftest import Home, ignore

from homebot.devices.handles import Handle, Light, MediaPlayer

pytestmark = pytest.mark.virtual_time


def told(lines: object) -> list[str]:
    return [re.sub(r"after [\d.]+ s", "after", one["message"]) for one in lines if one["event"].startswith("control.")]  # type: ignore[attr-defined]


async def test_each_command_that_is_sent_is_one_line_with_its_outcome_and_issuer(home: Home) -> None:
    home.put("lamp", "light", "on_off", "level")
    home.put("deaf", "light", "on_off")
    home.behaviours["deaf"] = ignore
    await home.report("lamp", "on_off", False)
    lamp, deaf = [await home.handle(Light, key) for key in ("lamp", "deaf")]
    with capture_logs() as lines:
        await lamp.turn_on()
        await lamp.turn_on()  # is on already: nothing is sent
        await lamp.set_level(40)
        await deaf.turn_on()
        await anyio.sleep(1)
    assert told(lines) == [
        "lamp → on, by app: confirmed after (reported)",
        "lamp → level 40 %, by app: confirmed after (reported)",
        "deaf → on, by app: no answer within 10 s",
    ]
    assert [one["log_level"] for one in lines][-1] == "warning"


async def test_a_press_and_a_muted_player_are_not_told_as_on(home: Home) -> None:
    home.put("bell", "x_setting", "push")
    home.put("tv", "video_player", "muted")
    with capture_logs() as lines:
        await (await home.handle(Handle, "bell")).command("push", True)
        await (await home.handle(MediaPlayer, "tv")).mute(muted=False)
        await anyio.sleep(1)
    assert [line.partition(", by")[0] for line in told(lines)] == ["bell → push", "tv → not muted"]


async def test_a_change_that_no_command_explains_has_both_values(home: Home) -> None:
    home.put("lamp", "light", "on_off", "level")
    await home.report("lamp", "on_off", False)
    await home.report("lamp", "level", 20.0)
    await anyio.sleep(20)
    lamp = await home.handle(Light)
    with capture_logs() as lines:
        await home.report("lamp", "on_off", True)
        await home.report("lamp", "level", 55.0)
        await anyio.sleep(1)
        await lamp.turn_off()
        await anyio.sleep(60)
    assert told(lines) == [
        "lamp: off → on, by hand",
        "lamp: level 20 % → 55 %, by hand",
        "lamp → off, by app: confirmed after (reported)",
    ]


async def test_a_flood_of_commands_leaves_a_line_a_second_and_their_number(home: Home) -> None:
    lamp = await home.lamp("on_off", "level")
    with capture_logs() as lines:
        for number in range(300):
            await lamp.set_level(1 + number % 100)
            await anyio.sleep(0.1)
        await anyio.sleep(60)
        await lamp.turn_off()
        await anyio.sleep(1)
    assert len(told(lines)) == 61
    assert told(lines)[-1].endswith("(and 240 more like this)")
