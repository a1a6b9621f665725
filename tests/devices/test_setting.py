"""A setting as a message."""

import pytest

from homebot.devices.command_messages import Setting
from homebot.devices.value import PlainValue, Value


@pytest.mark.parametrize("plain", [True, 1.0, False, 0.0, None, "on", (1.0, 2.0)])
def test_a_setting_has_the_capability_and_the_value_that_it_is_made_of(plain: PlainValue) -> None:
    """The type as well, also of equal values that were set before."""
    setting = Setting.of("level", plain)
    assert setting == Setting(capability="level", value=Value.of(plain))
    assert type(setting.value.plain()) is type(plain)
