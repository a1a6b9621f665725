"""The error tree: what messages say, and what facts errors keep."""

import pytest

from homebot import errors


def test_every_error_is_a_homebot_error() -> None:
    kinds = [one for one in vars(errors).values() if isinstance(one, type) and one.__module__ == errors.__name__]
    assert len(kinds) > 20
    assert all(issubclass(one, errors.HomebotError) for one in kinds)


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (
            errors.ConfigError("homebot.toml", "gateways.mqtt.url", "no scheme"),
            "homebot.toml: gateways.mqtt.url: no scheme",
        ),
        (errors.ConfigError("homebot.toml", "", "does not exist"), "homebot.toml does not exist"),
        (errors.PluginError("zigbee", "is not installed"), "plug-in 'zigbee' is not installed"),
        (errors.WireError("too short", b"\x01\xff"), "too short (frame: 01 ff)"),
        (errors.WireError("too short"), "too short"),
        (errors.RefusedError("the login", "bad password", 5), "the login was refused: bad password"),
        (
            errors.ServiceUnavailableError("/s"),
            "service /s has no server; wait for it with `await client.wait_for_service(timeout)`",
        ),
        (errors.ServiceFailedError("/s", "ValueError: x"), "service /s failed: ValueError: x"),
        (errors.ServiceGoneError("/s"), "service /s was closed during the call; whether it acted is unknown"),
        (errors.ServiceTimeoutError("/s", 0.5), "service /s did not answer within 0.5 s; whether it acted is unknown"),
    ],
)
def test_an_error_says_what_is_wrong_in_one_line(error: errors.HomebotError, text: str) -> None:
    assert str(error) == text


def test_a_long_frame_is_shown_by_its_first_64_bytes_and_kept_whole() -> None:
    error = errors.WireError("too long", bytes(100))
    assert str(error).endswith(f"{'00 ' * 63}00 …)")
    assert error.frame == bytes(100)


def test_a_service_time_out_is_also_a_plain_time_out() -> None:
    assert issubclass(errors.ServiceTimeoutError, TimeoutError)
