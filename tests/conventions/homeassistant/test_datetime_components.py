from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.settings import build_moment
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError


def moment(component: str) -> DescribedPart:
    return build_moment(DiscoveryConfig(component, "node_1", {"command_topic": "m/set", "state_topic": "m"}))


@pytest.mark.parametrize(
    ("component", "said", "expected"),
    [
        ("date", b"2026-11-20", {"text": "2026-11-20"}),
        ("date", b"20261120", {"text": "2026-11-20"}),
        ("time", b"07:30", {"text": "07:30:00"}),
        ("datetime", b"2026-11-20T07:30:00Z", {"text": "2026-11-20T07:30:00+00:00"}),
        ("date", b"None", {"text": None}),
        ("date", b"2026-13-20", {}),
        ("time", b"", {}),
        ("datetime", b"soon", {}),
    ],
)
def test_a_moment_is_heard_as_iso_8601_has_it(component: str, said: bytes, expected: Mapping[str, PlainValue]) -> None:
    assert moment(component).codec.read("m", said, retained=True) == expected


@pytest.mark.parametrize(
    ("component", "value", "payload"),
    [
        ("date", "2026-11-20", b"2026-11-20"),
        ("time", "07:30", b"07:30:00"),
        ("datetime", "2026-11-20T07:30:00+01:00", b"2026-11-20T07:30:00+01:00"),
    ],
)
def test_a_moment_is_told_as_home_assistant_does(component: str, value: str, payload: bytes) -> None:
    assert [one.payload for one in moment(component).codec.write("text", value)] == [payload]


@pytest.mark.parametrize(
    ("component", "value", "why"),
    [
        ("date", "tomorrow", "takes a date"),
        ("time", 7.5, "takes a time"),
        ("datetime", "2026-11-20T07:30:00", "time zone"),
    ],
)
def test_what_is_no_moment_is_refused(component: str, value: PlainValue, why: str) -> None:
    with pytest.raises(RefusedError, match=why):
        moment(component).codec.write("text", value)


def test_a_moment_is_a_setting_that_says_of_which_kind() -> None:
    assert (moment("time").part.service_type, moment("time").part.tag) == ("x_setting", "time")
