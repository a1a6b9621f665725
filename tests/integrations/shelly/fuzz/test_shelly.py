"""Damaged announcements and messages of Shelly over MQTT: refused in our words, or understood."""

from tests.fuzz.conftest import Fuzz, fuzz_convention
from tests.integrations.real_devices import rows_of

from homebot.integrations.shelly.formats import Shelly, ShellySettings


def test_damaged_devices_are_refused_or_read(fuzz: Fuzz) -> None:
    fuzz_convention(fuzz, "shelly", lambda: Shelly(ShellySettings()), rows_of("shelly"))
