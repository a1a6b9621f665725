"""What conventions make of a message that only a list of all devices may be as long as."""

import json
import time
from contextlib import suppress

import pytest

from homebot.conventions.convention import Convention
from homebot.conventions.installed_conventions import default_conventions, find_conventions
from homebot.errors import WireError

CONVENTIONS = find_conventions(default_conventions(), {}, "")


def topics(convention: Convention) -> list[str]:
    """A topic for each filter, and those of announcements where the filter alone does not make one."""
    fills = ("shellyplus1-a8032abe54dc", "light", "A8032ABE54DC")
    made = []
    for one in convention.filters():
        levels = one.replace("#", "+/+/config").split("/")
        names = iter(fills * 2)
        made.append("/".join(next(names) if level == "+" else level for level in levels))
    known = {
        "homeassistant": ["homeassistant/light/lamp/config", "homeassistant/device/lamp/config"],
        "tasmota": ["tasmota/discovery/A8032ABE54DC/config", "tasmota/discovery/A8032ABE54DC/sensors"],
        "homie": ["homie/lamp/$homie", "homie/5/lamp/$description", "homie/lamp/$nodes"],
    }
    return made + known.get(convention.name, [])


@pytest.fixture(scope="module")
def long() -> bytes:
    """A JSON object of 30 MiB."""
    return b'{"a":[' + b"1," * (15 * 1024 * 1024) + b"1]}"


@pytest.fixture(scope="module")
def bound() -> float:
    """Seconds of the processor in which a fifth of `long` is parsed."""
    began = time.thread_time()
    json.loads(b"[" + b"1," * (3 * 1024 * 1024) + b"1]")
    return time.thread_time() - began


@pytest.mark.no_cover
@pytest.mark.parametrize("convention", CONVENTIONS, ids=lambda one: one.name)
def test_a_message_of_30_mib_is_not_parsed_unless_it_is_the_list_of_a_bridge(
    convention: Convention, long: bytes, bound: float
) -> None:
    for topic in topics(convention):
        if topic.endswith(("/bridge/devices", "/bridge/info")):
            continue
        with suppress(WireError):
            convention.read_message(topic, b"{}", retained=True)  # loads the reader
        began = time.thread_time()
        with suppress(WireError):
            convention.read_message(topic, long, retained=True)
        assert time.thread_time() - began < bound, topic
