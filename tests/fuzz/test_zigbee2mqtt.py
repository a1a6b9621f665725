"""Damaged announcements and messages of ``zigbee2mqtt``: refused in our words, or understood."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from homebot.conventions.zigbee2mqtt import Zigbee2Mqtt, Zigbee2MqttSettings

if TYPE_CHECKING:
    from tests.fuzz.conftest import Fuzz


def test_damaged_devices_are_refused_or_read(fuzz: Fuzz, devices: Callable[[str], list[dict[str, Any]]]) -> None:
    fuzz.convention("zigbee2mqtt", lambda: Zigbee2Mqtt(Zigbee2MqttSettings()), devices("zigbee2mqtt"))
