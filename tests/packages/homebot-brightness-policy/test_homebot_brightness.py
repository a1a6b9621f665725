"""The tests of the policy, in a homebot that finds it by entry point."""

from __future__ import annotations

import json
from importlib.metadata import entry_points

import pytest

from homebot import App, ConfigError, Light, Outcome, Refused, Runtime, parse_config
from homebot.testing import TestHouse

CONFIG = {
    "command_topic": "desk/set",
    "brightness_command_topic": "desk/level",
    "unique_id": "desk",
    "device": {"identifiers": ["desk"], "name": "Desk", "suggested_area": "Study"},
}
TABLE = {"commands": ["turn on light in study"], "percent": 40}
OUTCOMES: list[Outcome] = []


@pytest.fixture
def homebot_config() -> dict[str, object]:
    return {"gateways": {"mqtt": {}}, "control": {"policies": {"brightness": TABLE}}}


class Bright(App):
    """Sets every lamp to two levels."""

    async def run(self) -> None:
        async for change in self.devices.follow(Light):
            if change.kind == "appeared":
                OUTCOMES.append(await change.handle.turn_on(level=80))
                OUTCOMES.append(await change.handle.turn_on(level=30))


def test_the_package_is_installed() -> None:
    """Else nothing here would be shown of entry points."""
    assert "brightness" in entry_points(group="homebot.policies").names


@pytest.mark.homebot.with_args(Bright)
async def test_no_app_makes_a_lamp_brighter_than_the_limit(homebot: TestHouse) -> None:
    OUTCOMES.clear()
    await homebot.says("homeassistant/light/desk/config", json.dumps(CONFIG))
    assert await homebot.hears("desk/level") in {"76", "77"}  # 30 % of 255
    (refused, *_) = OUTCOMES
    assert isinstance(refused, Refused)
    assert (refused.policy, refused.reason) == ("brightness", "desk is to be at most 40 % bright")


@pytest.mark.parametrize(
    ("tables", "problem"),
    [
        ({"brightness": TABLE | {"percent": 400}}, "brightness.percent: .* less than or equal to 100, got 400"),
        ({"brightness": TABLE | {"percnt": 40}}, "brightness.percnt: unknown key; did you mean percent?"),
        ({"brightness": TABLE | {"commands": ["turn on lihgts"]}}, "brightness.commands: .* did you mean lights?"),
        ({"brightnes": TABLE}, "did you mean brightness?"),
        ({"homebot_brightness:Brightness": TABLE}, "no installed package offers the policy"),
    ],
)
def test_a_table_that_fits_no_installed_policy_is_an_error(tables: dict[str, object], problem: str) -> None:
    config = parse_config({"gateways": {"mqtt": {}}, "control": {"policies": tables}}, "test")
    with pytest.raises(ConfigError, match=problem):
        Runtime(config)
