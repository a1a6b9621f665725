"""Setup codes of HomeKit in each of their spellings."""

import pytest

from homebot.errors import WireError
from homebot.integrations.homekit.formats.ecosystem import read_homekit_digits


@pytest.mark.parametrize("text", ["031-45-154", "03145154", "031 45 154", "X-HM://0023ISYWY", "x-hm://0023ISYWYABCD"])
def test_a_code_is_eight_digits_in_each_spelling(text: str) -> None:
    assert read_homekit_digits(text) == "031-45-154"


@pytest.mark.parametrize("text", ["", "1234567", "123-45-67a", "X-HM://00", "١٢٣٤٥٦٧٨"])
def test_what_is_no_code_is_refused_without_showing_it(text: str) -> None:
    with pytest.raises(WireError) as caught:
        read_homekit_digits(text)
    assert not text or text not in str(caught.value)
