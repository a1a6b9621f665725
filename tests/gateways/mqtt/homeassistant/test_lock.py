import pytest

from homebot.errors import RefusedError
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.lock import build_lock


def test_a_lock_that_wants_a_code_cannot_be_told() -> None:
    part = build_lock(Config("lock", "x", {"command_topic": "l/set", "code_format": "^\\d{4}$"}))
    with pytest.raises(RefusedError, match="code"):
        part.codec.write("lock", "unlocked")


def test_a_lock_without_a_latch_is_not_told_to_open() -> None:
    part = build_lock(Config("lock", "x", {"command_topic": "l/set"}))
    with pytest.raises(RefusedError, match="locked, unlocked"):
        part.codec.write("lock", "open")
