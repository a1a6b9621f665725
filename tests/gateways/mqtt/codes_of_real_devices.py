"""The configs of the 1,495 real ones that have nothing but a code that is reported, and never read."""

from typing import Final

CODES: Final = frozenset(
    {
        "sensor/0x00158d0000000169/last_added_user_code",
        "sensor/0x00158d00000003a3/pin_code",
        "sensor/0x00158d0000000cc7/pin_code",
        "sensor/0x00158d0000001120/pin_code",
    }
)
"""``COMPONENT/DEVICE/OBJECT``, as in the topics."""
