"""Codes and passwords that Home Assistant discovery announces: they may be set, and are never read."""

from collections.abc import Mapping

import pytest
from tests.integrations.announced_parts import homeassistant_parts

from homebot.conventions.description import DescribedPart

STATE = "zigbee2mqtt/door"
MESSAGE = b'{"state": "LOCK", "battery": 80, "user_code": 4711, "pin_code": "4711", "x": "4711"}'


def parts(component: str, fields: Mapping[str, object]) -> tuple[DescribedPart, ...]:
    config = {"state_topic": STATE, "unique_id": "0x1_x", **fields}
    if component != "sensor":
        config["command_topic"] = f"{STATE}/set"
    return homeassistant_parts(component, config)


CODES = [
    *(
        "PIN code",
        "Last used pin code",
        "User code",
        "Wi-Fi password",
        "Guest passcode",
        "Guest PIN",
        "PIN",
        "Entry pin",
    ),
    *("Door code 2", "Access codes", "Disarm code", "Wi-Fi QR code", "API key", "Access token", "Bindkey"),
]
OTHERS = [
    *(
        "Error code",
        "Barcode",
        "Country code",
        "User",
        "Encode",
        "Superuser codec",
        "Alarm code",
        "Pin 4",
        "GPIO PIN 4",
    ),
    *("Door PINS", "Key", "Outdoor code", "Network keyboard", "Master pin mode"),
]


@pytest.mark.parametrize(
    "fields",
    [
        *({"name": name} for name in CODES),
        {"name": "x", "value_template": "{{ value_json.networkKey }}"},
        {"unique_id": "lock_master_code"},
        {"unique_id": "0x1_action_code_zigbee2mqtt"},
        {"name": "Code", "value_template": '{{ value_json["pin_code"] }}'},
    ],
    ids=str,
)
def test_a_code_or_password_is_not_read(fields: Mapping[str, object]) -> None:
    fields = {"value_template": "{{ value_json.x }}", **fields}
    assert parts("sensor", fields) == ()
    for component in ("text", "number"):
        (one,) = parts(component, {"max": 255, **fields})
        assert [(two.readable, two.settable) for two in one.part.capabilities] == [(False, True)]
        assert one.codec.topics() == ()


@pytest.mark.parametrize(
    "fields",
    [
        *({"name": name} for name in OTHERS),
        {"name": "Battery", "unique_id": "pin_code_pad_battery"},
        {"name": "Pin code pad", "device_class": "battery"},
    ],
    ids=str,
)
def test_a_value_with_another_name_is_read(fields: Mapping[str, object]) -> None:
    (one,) = parts("sensor", {"value_template": "{{ value_json.battery }}", **fields})
    assert list(one.codec.read(STATE, MESSAGE, retained=False).values()) in ([80.0], ["80"])


def test_a_message_that_is_shown_as_it_is_has_no_code() -> None:
    """As of a sensor without a template, or with an unsupported one."""
    (whole,) = parts("sensor", {"name": "State"})
    assert whole.codec.read(STATE, MESSAGE, retained=False) == {}
    assert whole.codec.read(STATE, b"Enter the user code", retained=False) == {"value": "Enter the user code"}
    (one,) = parts("sensor", {"name": "Odd", "value_template": "{{ states('x') }}"})
    assert [two.name for two in one.part.capabilities] == ["raw"]
    assert one.codec.read(STATE, MESSAGE, retained=False) == {}
    assert one.codec.read(STATE, b"fine", retained=False) == {"raw": "fine"}
