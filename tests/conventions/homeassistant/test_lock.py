import pytest

from homebot.conventions.description import TakesCode
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.lock import build_lock
from homebot.errors import RefusedError, WrongCodeError


def test_a_lock_that_wants_a_code_is_told_with_one() -> None:
    template = '{"do": "{{ value }}", "code": "{{ code }}"}'
    fields = {"command_topic": "l/set", "code_format": "^\\d{4}$", "command_template": template}
    codec = build_lock(DiscoveryConfig("lock", "x", fields)).codec
    with pytest.raises(WrongCodeError, match="it needs a code"):
        codec.write("lock", "unlocked")
    assert isinstance(codec, TakesCode)
    (told,) = codec.write_with_code("lock", "unlocked", "1234")
    assert told.payload == b'{"do": "UNLOCK", "code": "1234"}'


def test_a_lock_without_a_latch_is_not_told_to_open() -> None:
    part = build_lock(DiscoveryConfig("lock", "x", {"command_topic": "l/set"}))
    with pytest.raises(RefusedError, match="locked, unlocked"):
        part.codec.write("lock", "open")
