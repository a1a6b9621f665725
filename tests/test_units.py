"""Durations as people write them."""

import inspect
import math
import re
from collections.abc import Iterator
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from homebot.config import parse_settings
from homebot.control import ControlSettings
from homebot.discovery import DirectorySettings
from homebot.errors import ConfigError, UsageError
from homebot.gateways.coap.settings import CoapGatewaySettings
from homebot.gateways.mqtt.settings import MqttGatewaySettings
from homebot.robots.settings import RobotSettings
from homebot.runtime.rosbridge_table import RosbridgeTable
from homebot.units import DURATION, MAX_WAIT, Seconds, parse_duration


@pytest.mark.parametrize(
    ("text", "seconds"),
    [
        ("90s", 90.0),
        ("8h", 28_800.0),
        ("1h30m", 5_400.0),
        ("1h 30m", 5_400.0),
        (" 2 d ", 172_800.0),
        ("1.5d", 129_600.0),
        ("500ms", 0.5),
        ("1m500ms", 60.5),
        ("1d2h3m4s5ms", 93_784.005),
        ("0s", 0.0),
        ("8 hours", 28_800.0),
        ("8H", 28_800.0),
        ("10 minutes", 600.0),
        ("half an hour", 1_800.0),
        ("1 hour and 30 min", 5_400.0),
        (90, 90.0),
        (0.25, 0.25),
    ],
)
def test_a_duration_is_read(text: str | float, seconds: float) -> None:
    assert parse_duration(text) == pytest.approx(seconds)


@pytest.mark.parametrize(
    "text", ["", " ", "8", "8 lamps", "h", "half", "30m1h", "1h and", "1h1h", "-5s", "1,5h", "1..5s", "٣s"]
)
def test_what_is_no_duration_is_refused_with_an_example(text: str) -> None:
    with pytest.raises(UsageError, match=r"is not a duration; write it like 90s, 8h or 1h30m"):
        parse_duration(text)


@pytest.mark.parametrize("number", [-1.0, math.inf, math.nan])
def test_a_number_that_is_no_time_is_refused(number: float) -> None:
    with pytest.raises(UsageError, match="finite number of seconds, 0 or more"):
        parse_duration(number)


@pytest.mark.parametrize("text", ["999999999h", "36601d", "1" * 400 + "s", 1e300])
def test_what_is_longer_than_a_life_is_refused_with_the_most_that_is_possible(text: str | float) -> None:
    shown = repr(text) if isinstance(text, str) else text
    with pytest.raises(UsageError, match=re.escape(f"{shown} is more than 100 years, the most that is possible")):
        parse_duration(text, most=MAX_WAIT)


class Table(BaseModel):
    limit: Seconds = 1.0
    whole: Annotated[int, DURATION] = 1


def test_a_table_reads_seconds_as_a_number_or_a_text() -> None:
    table = parse_settings(Table, {"limit": "500ms", "whole": "7d"}, "homebot.toml", "apps.hall")
    assert table == Table(limit=0.5, whole=604_800)
    assert parse_settings(Table, {"limit": 3}, "", "").limit == 3.0


@pytest.mark.parametrize(
    ("value", "said"),
    [
        ("soon", "apps.hall.limit: 'soon' is not a duration; write it like 90s, 8h or 1h30m"),
        ("0s", "apps.hall.limit: input should be greater than 0"),
        (True, "apps.hall.limit: must be a number, without quotes, got true"),
    ],
)
def test_what_is_no_duration_in_a_table_is_named(value: object, said: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(said)):
        parse_settings(Table, {"limit": value}, "homebot.toml", "apps.hall")


def _keys_in_seconds() -> Iterator[tuple[type[BaseModel], str]]:
    """Yield the keys in the docs' tables that are in seconds, with their tables' models."""
    for model in (
        RosbridgeTable,
        DirectorySettings,
        ControlSettings,
        MqttGatewaySettings,
        CoapGatewaySettings,
        RobotSettings,
    ):
        docs = "\n".join(inspect.getdoc(one) or "" for one in model.__mro__ if issubclass(one, BaseModel))
        for key in re.findall(r"^ +(\w+): Seconds", docs, re.MULTILINE):
            yield model, key


@pytest.mark.parametrize(("model", "key"), [*_keys_in_seconds()])
def test_every_key_in_seconds_reads_a_duration(model: type[BaseModel], key: str) -> None:
    assert getattr(parse_settings(model, {key: "20s"}, "", ""), key) == 20.0


@given(st.integers(0, 99), st.integers(0, 99), st.integers(0, 99))
def test_parts_add_up(hours: int, minutes: int, seconds: int) -> None:
    assert parse_duration(f"{hours}h{minutes}m{seconds}s") == hours * 3600 + minutes * 60 + seconds
