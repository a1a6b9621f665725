"""Damaged announcements and messages of Tasmota: refused in our words, or understood."""

from tests.fuzz.conftest import Fuzz, fuzz_convention
from tests.integrations.real_devices import rows_of

from homebot.integrations.tasmota.formats import TasmotaDiscovery, TasmotaSettings


def test_damaged_devices_are_refused_or_read(fuzz: Fuzz) -> None:
    fuzz_convention(fuzz, "tasmota", lambda: TasmotaDiscovery(TasmotaSettings()), rows_of("tasmota"))
