"""BTHome v2: measurements and events that a device broadcasts by Bluetooth Low Energy. Pure.

Source: https://bthome.io/format and https://bthome.io/encryption, read in November 2026.
"""

from homebot.conventions.bthome.objects import BTHOME_OBJECTS, BTHomeObject
from homebot.conventions.bthome.packet import BTHomePacket, Measured, read_packet

__all__ = ["BTHOME_OBJECTS", "BTHomeObject", "BTHomePacket", "Measured", "read_packet"]
