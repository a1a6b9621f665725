"""Reads the identity of beacons: iBeacon and Eddystone-UID. Pure.

Sources: Apple, Proximity Beacon Specification R1 (company 0x004C, type 0x02, length 0x15); Google, Eddystone-UID
(service 0xFEAA, frame type 0x00). A beacon says how strongly it is received: an iBeacon at 1 m, Eddystone at 0 m, which
is 41 dB more. Its identifier lasts; its address need not.
"""

from uuid import UUID

from homebot.conventions.bluetooth.broadcast import Advertisement, Broadcast, BroadcastParser, full_uuid
from homebot.errors import WireError

APPLE = 0x004C
EDDYSTONE = full_uuid("feaa")
_IBEACON = b"\x02\x15"
_IBEACON_SIZE = 23
_UID_SIZE = 18
_LOSS_AT_1M = 41.0


class BeaconParser(BroadcastParser):
    """Reads iBeacon and Eddystone-UID."""

    def concerns(self, advertisement: Advertisement) -> bool:
        """Return whether it is an iBeacon or Eddystone-UID."""
        return (
            advertisement.manufacturer_data.get(APPLE, b"").startswith(_IBEACON)
            or advertisement.service_data.get(EDDYSTONE, b"?")[:1] == b"\x00"
        )

    def read(self, advertisement: Advertisement, now: float) -> Broadcast | None:
        """Return the identity of a beacon.

        Raises:
            WireError: It is truncated.
        """
        del now
        data = advertisement.manufacturer_data.get(APPLE, b"")
        if data.startswith(_IBEACON):
            return _ibeacon(data, advertisement.name)
        return _eddystone(advertisement.service_data[EDDYSTONE], advertisement.name)


def _ibeacon(data: bytes, name: str) -> Broadcast:
    if len(data) < _IBEACON_SIZE:
        raise WireError("iBeacon: it is cut off", data)
    uuid = str(UUID(bytes=bytes(data[2:18])))
    major, minor = int.from_bytes(data[18:20], "big"), int.from_bytes(data[20:22], "big")
    identity = f"ibeacon:{uuid}/{major}/{minor}"
    return Broadcast(
        key=identity,
        name=name or f"iBeacon {major}/{minor}",
        metadata={"format": "iBeacon", "uuid": uuid, "major": str(major), "minor": str(minor)},
        identifiers=(identity,),
        rssi_at_1m=float(int.from_bytes(data[22:23], "big", signed=True)),
    )


def _eddystone(data: bytes, name: str) -> Broadcast:
    if len(data) < _UID_SIZE:
        raise WireError("Eddystone: it is cut off", data)
    namespace, instance = data[2:12].hex(), data[12:18].hex()
    return Broadcast(
        key=f"eddystone:{namespace}/{instance}",
        name=name or f"Eddystone {instance}",
        metadata={"format": "Eddystone-UID", "namespace": namespace, "instance": instance},
        identifiers=(f"eddystone:{instance}@{namespace}",),  # twelve digits at the end would be an address
        rssi_at_1m=int.from_bytes(data[1:2], "big", signed=True) - _LOSS_AT_1M,
    )
