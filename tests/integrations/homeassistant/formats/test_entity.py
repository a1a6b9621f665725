import pytest
from tests.integrations.announced_parts import homeassistant_part

from homebot.conventions.payload import fields_of, number_of, numbers_of, whole_of
from homebot.errors import WireError
from homebot.integrations.homeassistant.formats.config import DiscoveryConfig
from homebot.integrations.homeassistant.formats.entity import Entity, Scale


def entity(**fields: object) -> Entity:
    return Entity(DiscoveryConfig("sensor", "node x", fields), "x_sensor")


@pytest.mark.parametrize("otherwise", ["if value_json.t is defined else this.state", "| default(this.state)"])
def test_a_message_with_which_a_template_asks_for_its_last_state_changes_nothing(otherwise: str) -> None:
    """The WeeWX extension MQTTConfigHA has it as a default."""
    template = f"{{{{ value_json.t {otherwise} }}}}"
    config = {"state_topic": "a", "value_template": template, "unit_of_measurement": "°C"}
    codec = homeassistant_part("temperature", "sensor", config).codec
    payloads = (b'{"t": 20.5}', b'{"rssi": -60}', b'{"t": 0}')
    found = [dict(codec.read("a", one, retained=False)) for one in payloads]
    assert found == [{"temperature": 20.5}, {}, {"temperature": 0.0}]


LOCK = {"command_topic": "a/set", "state_topic": "a"}


@pytest.mark.parametrize(
    ("name", "service_type"), [("Child lock", "x_setting"), ("TRV keypad lock", "x_setting"), ("Lock", "door_lock")]
)
def test_a_lock_of_keys_is_a_setting_by_its_name(name: str, service_type: str) -> None:
    lock = homeassistant_part("lock" if service_type == "door_lock" else "on_off", "lock", {"name": name, **LOCK})
    assert lock.part.service_type == service_type


@pytest.mark.parametrize(
    ("changed", "is_approved"),
    [
        ({"payload_unlock": "LOCK", "payload_lock": "UNLOCK"}, False),
        ({"command_template": "UNLOCK"}, False),
        ({"name": "Porch", "icon": "mdi:door", "state_locked": "yes", "value_template": "{{ value }}"}, True),
    ],
)
def test_an_approval_of_a_lock_is_none_of_one_that_is_sent_something_else(
    changed: dict[str, str], *, is_approved: bool
) -> None:
    approved, now = (homeassistant_part("lock", "lock", LOCK | more).part for more in ({}, changed))
    assert (now.payloads == approved.payloads) is is_approved


@pytest.mark.parametrize(
    ("zero", "full", "value", "percent"), [(0, 100, 33.3, 33), (100, 0, 20, 80), (3, 17, 10, 50), (0, 3, 2, 66)]
)
def test_a_scale_counts_whole_percents(zero: int, full: int, value: float, percent: float) -> None:
    assert Scale(zero, full).percent(value) == percent


def test_a_value_beyond_any_scale_is_far_outside() -> None:
    assert Scale(0, 100).percent(1e308) > 100
    assert Scale(100, 0).percent(1e308) < 0


def test_a_scale_without_length_is_refused() -> None:
    with pytest.raises(WireError):
        Scale(5, 5)


def test_rendered_texts_are_read_without_raising() -> None:
    assert (number_of(value=True), number_of("7.5"), number_of("nan")) == (1.0, 7.5, None)
    assert (whole_of("7"), whole_of("7.0"), whole_of("9" * 5_000)) == (7, None, None)
    assert numbers_of("1,2.5", 2) == (1.0, 2.5)
    assert [numbers_of(text, 2) for text in ("1", "1,2,3", "1,x", "")] == [None] * 4
    assert fields_of(' {"a": 1}') == {"a": 1}
    assert [fields_of(text) for text in ("[1]", "{", "x", "")] == [{}] * 4


@pytest.mark.parametrize(
    ("shown", "tag"),
    [
        ({"icon": "mdi:gate"}, "mdi:gate"),
        ({"ic": "mdi:gate", "dev_cla": "switch"}, "mdi:gate"),
        ({"dev_cla": "outlet"}, "outlet"),
        ({}, ""),
    ],
)
def test_the_icon_of_what_can_be_set_is_its_kind_without_a_class(shown: dict[str, str], tag: str) -> None:
    """What an icon says of a relay is what its owner means by it."""
    assert homeassistant_part("on_off", "switch", {"command_topic": "a/set", **shown}).part.tag == tag
