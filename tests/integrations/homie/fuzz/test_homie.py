"""Damaged announcements and messages of Homie: refused in our words, or understood."""

from tests.fuzz.conftest import Fuzz, fuzz_convention
from tests.integrations.real_devices import rows_of

from homebot.integrations.homie.formats import Homie, HomieSettings


def test_damaged_devices_are_refused_or_read(fuzz: Fuzz) -> None:
    fuzz_convention(fuzz, "homie", lambda: Homie(HomieSettings()), rows_of("homie"))
