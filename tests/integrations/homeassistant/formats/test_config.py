from collections.abc import Callable

import pytest

from homebot.conventions.description import Publication
from homebot.errors import RefusedError, WireError
from homebot.integrations.homeassistant.formats.config import MAX_OPTIONS, DiscoveryConfig


def config(**fields: object) -> DiscoveryConfig:
    return DiscoveryConfig("light", "lamp", fields)


def test_the_fields_of_commands_say_which_of_them_share_a_topic_and_not_which_topic() -> None:
    kinds = ("command_topic", "set_position_topic", "tilt_command_topic")
    told = [config(**dict(zip(kinds, topics, strict=True))).of_commands() for topics in ("abb", "aba", "cdd", "abc")]
    assert told[0] == told[2] != told[1]
    assert told[3] == []


@pytest.mark.parametrize(
    ("value", "flag"),
    [(True, True), ("Yes", True), (" on ", True), (1, True), (0.0, False), ("disable", False), (None, True)],
)
def test_a_flag_has_many_words(value: object, flag: object) -> None:
    assert config(k=value).flag("k", default=True) is flag


@pytest.mark.parametrize(
    ("read", "value"),
    [
        (lambda one: one.text("k"), []),
        (lambda one: one.text("k"), 10**40),
        (lambda one: one.text("k"), "x" * 9_000),
        (lambda one: one.flag("k"), "perhaps"),
        (lambda one: one.flag("k"), [True]),
        (lambda one: one.integer("k", 0, least=0), -1),
        (lambda one: one.integer("k", 0), "7.5"),
        (lambda one: one.integer("k", 0), float("inf")),
        (lambda one: one.integer("k", 0), "9" * 5_000),
        (lambda one: one.number("k", 0), "nan"),
        (lambda one: one.number("k", 0), 10**400),
        (lambda one: one.options("k"), [[]]),
        (lambda one: one.options("k"), ["x"] * (MAX_OPTIONS + 1)),
        (lambda one: one.options("k"), ["x" * 256]),
        (lambda one: one.template("k"), 3.5j),
        (lambda one: one.state_topic("k"), "a+"),
        (lambda one: one.command("k"), "a/#"),
        (lambda one: one.required_command("k"), None),
        (lambda one: one.required_source("k"), None),
    ],
)
def test_a_field_that_cannot_be_is_refused_shortly(read: Callable[[DiscoveryConfig], object], value: object) -> None:
    with pytest.raises(WireError) as refused:
        read(config(k=value))
    assert len(str(refused.value)) < 200


@pytest.mark.parametrize(
    ("encoding", "payload", "text"),
    [
        ("utf-8", "ü".encode(), "ü"),
        ("latin-1", b"\xfc", "ü"),
        ("", b"abc", None),
        ("idna", "ü".encode(), "ü"),
        ("utf-8", b"\xfc", None),
    ],
)
def test_a_source_reads_the_encoding_of_its_config(encoding: str, payload: bytes, text: str | None) -> None:
    source = config(encoding=encoding, state_topic="a").required_source("state_topic")
    assert source.text(payload) == text


@pytest.mark.parametrize(
    ("template", "payload", "text"),
    [
        ("{{ value_json.state }}", b"ON", "ON"),
        ("{{ value_json['a'].b }}", b'{"a": 1}', ""),
        ("{{ value_json.a.b }}", b"{}", "{}"),
        ("{{ value_json.state | is_defined }}", b"{}", "{}"),
        ("{{ value_json.state | upper }}", b"on", "on"),
        ("{{ value_json.x + 1 }}", b"7", "7"),
        ("{{ value | int }}", b"x", None),
        ("{{ value_json.x | round(1) }}", b'{"x": "y"}', None),
        ("{{ value_json }}", b"ON", ""),
        ("{% if value_json.a.b %}1{% endif %}", b"ON", "ON"),
    ],
)
def test_without_its_variables_a_template_yields_the_payload(template: str, payload: bytes, text: str | None) -> None:
    """As in Home Assistant, which passes the message over only where the values do not fit the template."""
    source = config(state_topic="a", value_template=template).required_source("state_topic")
    assert source.text(payload) == text
    if text is not None and text == payload.decode():
        assert source.without_payload().text(payload) is None


def test_a_command_has_the_qos_retain_and_encoding_of_its_config() -> None:
    command = config(command_topic="a", qos=1, retain=True, encoding="latin-1").required_command()
    assert command.publication("ü") == Publication("a", b"\xfc", qos=1, retain=True)
    with pytest.raises(RefusedError, match="latin-1"):
        command.publication("灯")


def test_a_command_without_template_takes_none_from_a_nameless_field() -> None:
    command = DiscoveryConfig("light", "lamp", {"command_topic": "a", "": "{{ 1 }}"}).required_command(template_key="")
    assert command.template is None


def test_null_and_absent_are_one_for_a_text_and_two_for_a_payload() -> None:
    assert config(k=None).payload("k", "OPEN") is None
    assert config().payload("k", "OPEN") == "OPEN"


@pytest.mark.parametrize(("value", "whole"), [(7, 7), ("7", 7), (7.9, 7), (True, 1), (None, 3)])
def test_a_whole_number_may_be_a_text_or_have_a_fraction(value: object, whole: int) -> None:
    assert config(k=value).integer("k", 3, least=0, most=10) == whole


def test_a_source_gives_its_template_the_message_and_its_own_variables() -> None:
    one = config(state_topic="a", value_template="{{ value_json.n + more }}")
    source = one.source("state_topic", variables={"more": 2})
    assert source is not None
    assert source.text(b'{"n": 3}') == "5"
    assert source.without_payload().text(b"{}") is None
