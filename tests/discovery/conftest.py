"""An index for described devices."""

import pytest

from homebot.discovery import DeviceIndex


@pytest.fixture
def index() -> DeviceIndex:
    return DeviceIndex(forget_after=1000.0)
