"""The arguments of the mark."""

from __future__ import annotations

import pytest

from homebot.errors import InvalidNameError, UsageError
from homebot.mqtt.broker import BrokerLimits
from homebot.testing.mqtt import BrokerSettings


def test_without_arguments_everybody_may_do_everything() -> None:
    assert BrokerSettings.parse({}) == BrokerSettings()
    assert BrokerSettings().credentials is None
    assert BrokerSettings().refused_filters == ()


def test_one_filter_or_several_may_be_refused() -> None:
    assert BrokerSettings(refuse_filter="a/#").refused_filters == ("a/#",)
    assert BrokerSettings(refuse_filter=["a", "b"]).refused_filters == ("a", "b")


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ({"keepalive": 5}, "there is no argument 'keepalive'; did you mean keep_alive?"),
        ({"colour": 5}, "there is no argument 'colour'; there are: user, password, tls, keep_alive"),
        ({"user": "u"}, "user and password go together"),
        ({"user": 5, "password": "p"}, "user is text, not 5"),
        ({"tls": "yes"}, "tls is True or False, not 'yes'"),
        ({"keep_alive": 0}, "a keep-alive of 0 s is not from 1 to 65535"),
        ({"keep_alive": True}, "keep_alive is a whole number of seconds, not True"),
        ({"keep_alive": 1.5}, "keep_alive is a whole number of seconds, not 1.5"),
        ({"limits": {"max_queued_messages": 3}}, "limits is a BrokerLimits, not {"),
        ({"refuse_filter": 7}, "refuse_filter is a topic filter or a list of them, not 7"),
        ({"refuse_filter": [7]}, "refuse_filter is a topic filter or a list of them, not 7"),
        ({"allow_protocol_errors": 1}, "allow_protocol_errors is True or False, not 1"),
    ],
)
def test_a_wrong_argument_is_refused_in_words(arguments: dict[str, object], problem: str) -> None:
    with pytest.raises(UsageError) as caught:
        BrokerSettings.parse(arguments)
    assert problem in str(caught.value)


def test_a_filter_that_is_none_is_refused() -> None:
    with pytest.raises(InvalidNameError):
        BrokerSettings(refuse_filter="a/#/b")


def test_a_password_is_never_shown() -> None:
    with pytest.raises(UsageError) as caught:
        BrokerSettings.parse({"user": "u", "password": b"hunter2"})
    settings = BrokerSettings(user="u", password="hunter2", limits=BrokerLimits())
    assert "hunter2" not in f"{caught.value} {settings}"
