import pytest

from homebot.conventions.description import TakesCode
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.locks import build_lock
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


def test_a_lock_that_keeps_children_from_the_keys_is_a_setting() -> None:
    """As Zigbee2MQTT announced them for years: a thermostat's is no door that somebody locks at night."""
    fields = {"command_topic": "z/trv/set/child_lock", "state_topic": "z/trv", "name": "Child lock"}
    fields |= {"payload_lock": "LOCK", "payload_unlock": "UNLOCK", "state_locked": "LOCK", "state_unlocked": "UNLOCK"}
    fields["value_template"] = "{{ value_json.child_lock }}"
    part = build_lock(DiscoveryConfig("lock", "homeassistant/lock/0x0123/child_lock", fields))
    assert (part.part.service_type, part.part.category) == ("x_setting", "config")
    assert dict(part.codec.read("z/trv", b'{"child_lock": "LOCK"}', retained=False)) == {"on_off": True}
    (told,) = part.codec.write("on_off", value=False)
    assert (told.topic, told.payload) == ("z/trv/set/child_lock", b"UNLOCK")
