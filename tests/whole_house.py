"""Marks of tests with a house of several integrations, which are skipped where one of these is taken out."""

import pytest

WHOLE_HOUSE = pytest.mark.rooms("homeassistant", "homie", "shelly", "tasmota", "thesis", "zigbee2mqtt")
"""For the home of the family, the mixed house, and ``homebot run`` without a house."""
