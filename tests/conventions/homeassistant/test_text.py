from collections.abc import Mapping

import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.settings import build_notify, build_text
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError

DISPLAY = {"command_topic": "display/set", "state_topic": "display", "min": 1, "max": 20, "pattern": "(a+)+$"}


def text(fields: Mapping[str, object]) -> DescribedPart:
    return build_text(DiscoveryConfig("text", "node_1", fields))


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        (b"Hello", {"text": "Hello"}),
        (b"", {"text": ""}),
        (b"None", {"text": None}),
        (b"two\nlines", {"text": "two lines"}),
        (b"x" * 256, {}),
    ],
)
def test_a_text_is_heard_on_one_line(said: bytes, expected: Mapping[str, PlainValue]) -> None:
    assert text(DISPLAY).codec.read("display", said, retained=True) == expected


def test_a_text_is_told() -> None:
    (publication,) = text(DISPLAY).codec.write("text", "a" * 19 + "!")
    assert (publication.topic, publication.payload) == ("display/set", b"a" * 19 + b"!")


@pytest.mark.parametrize("value", ["", "x" * 21, 4.0, None])
def test_a_text_of_another_length_is_refused_without_being_shown(value: PlainValue) -> None:
    with pytest.raises(RefusedError, match="1 to 20 characters") as refused:
        text(DISPLAY).codec.write("text", value)
    assert "xx" not in str(refused.value)


def test_a_password_is_told_but_never_read() -> None:
    part = text({**DISPLAY, "mode": "password"})
    assert not part.part.capabilities[0].readable
    assert part.codec.topics() == ()
    assert part.codec.write("text", "secret")


def test_a_message_is_told_to_what_shows_it() -> None:
    part = build_notify(
        DiscoveryConfig("notify", "node_1", {"command_topic": "tv", "command_template": "msg={{ value }}"})
    )
    assert [one.payload for one in part.codec.write("text", "Tea!")] == [b"msg=Tea!"]
    assert part.part.service_type == "x_setting"


@pytest.mark.parametrize("fields", [{}, {**DISPLAY, "min": 30}, {**DISPLAY, "max": 256}, {**DISPLAY, "min": -1}])
def test_a_config_that_home_assistant_would_not_take_is_refused(fields: Mapping[str, object]) -> None:
    with pytest.raises(WireError):
        text(fields)
