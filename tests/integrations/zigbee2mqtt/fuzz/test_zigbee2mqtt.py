"""Damaged announcements and messages of Zigbee2MQTT: refused in our words, or understood."""

from tests.fuzz.conftest import Fuzz, fuzz_convention
from tests.integrations.real_devices import rows_of

from homebot.integrations.zigbee2mqtt.formats import Zigbee2Mqtt, Zigbee2MqttSettings


def test_damaged_devices_are_refused_or_read(fuzz: Fuzz) -> None:
    fuzz_convention(fuzz, "zigbee2mqtt", lambda: Zigbee2Mqtt(Zigbee2MqttSettings()), rows_of("zigbee2mqtt"))
