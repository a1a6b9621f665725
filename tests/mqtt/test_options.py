"""Addresses and limits of an MQTT connection."""

from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from homebot.errors import UsageError
from homebot.mqtt.options import MqttOptions


@pytest.mark.parametrize(
    ("url", "host", "port", "tls"),
    [
        ("mqtt://broker", "broker", 1883, False),
        ("mqtts://broker/", "broker", 8883, True),
        ("mqtt://192.0.2.7:1884", "192.0.2.7", 1884, False),
        ("mqtt://[::1]:1885", "::1", 1885, False),
    ],
)
def test_an_address_is_read(url: str, host: str, port: int, *, tls: bool) -> None:
    options = MqttOptions.from_url(url)
    assert (options.host, options.port, options.tls) == (host, port, tls)
    assert options.user is None
    assert options.password is None


def test_user_and_password_are_percent_decoded() -> None:
    options = MqttOptions.from_url("mqtt://k%C3%BCche:p%2F%40ss@broker")
    assert options.user == "küche"
    assert options.password is not None
    assert options.password.get_secret_value() == "p/@ss"


def test_neither_the_text_form_nor_the_url_shows_the_password() -> None:
    options = MqttOptions.from_url("mqtt://user:hunter2@broker")
    assert "hunter2" not in f"{options!r} {options} {options.url}"
    assert options.url == "mqtt://broker:1883"


def test_the_shown_url_keeps_the_brackets_of_an_ipv6_address() -> None:
    assert MqttOptions.from_url("mqtts://[fe80::1]").url == "mqtts://[fe80::1]:8883"


@pytest.mark.parametrize(
    ("url", "problem"),
    [
        ("http://broker", "must start with mqtt://"),
        ("broker:1883", "must start with mqtt://"),
        ("mqtt://", "host is missing"),
        ("mqtt://:1883", "host is missing"),
        ("mqtt://::1", "an IPv6 address stands in brackets"),
        ("mqtt://my broker", "host is not a host name or address"),
        ("mqtt://broker:99999", "port"),
        ("mqtt://broker:0", "port"),
        ("mqtt://broker:secret1", "port"),
        ("mqtt://[::1", "host"),
        ("mqtt://broker/topic", "nothing may follow the port"),
        ("mqtt://user:secret1/x@broker", "port"),
        ("mqtt://user:secret1?@broker", "port"),
        ("mqtt://" + "a" * 70 + ".example", "host"),
    ],
)
def test_a_bad_address_is_named_without_its_password(url: str, problem: str) -> None:
    with pytest.raises(UsageError, match=problem) as caught:
        MqttOptions.from_url(url)
    assert "secret1" not in str(caught.value)
    assert caught.value.__cause__ is None
    assert caught.value.__suppress_context__ or caught.value.__context__ is None


@pytest.mark.parametrize(
    ("settings", "problem"),
    [
        ({"password": "x"}, "password needs a user"),
        ({"ca_file": Path("ca.pem")}, "mqtts"),
        ({"tls": True, "key_file": Path("k.pem")}, "certificate"),
        ({"client_id": ""}, "client id"),
        ({"keep_alive": 0}, "keep alive"),
        ({"timeout": 0.0}, "timeout"),
        ({"session_expiry": -1}, "session expiry"),
        ({"maximum_packet_size": 10}, "maximum packet size"),
        ({"receive_maximum": 0}, "receive maximum"),
        ({"inbox_messages": 0}, "inbox"),
        ({"protocol": "4"}, "protocol"),
    ],
)
def test_a_value_out_of_range_is_refused(settings: dict[str, Any], problem: str) -> None:
    with pytest.raises(UsageError, match=problem):
        MqttOptions(host="broker", **settings)


@given(st.text())
def test_any_text_is_read_or_refused(text: str) -> None:
    try:
        MqttOptions.from_url("mqtt://" + text)
    except UsageError:
        return
