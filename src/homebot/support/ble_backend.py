"""The Bluetooth stack that a gateway uses, as a service of its host: the gateway and the host both know it."""

from dataclasses import dataclass

__all__ = ["BleBackend"]


@dataclass(frozen=True, slots=True, eq=False)
class BleBackend:
    """The two classes by which bleak reaches a Bluetooth stack; see ``backend=`` of its scanner and its client.

    Without this service the gateway uses bleak's own: BlueZ, CoreBluetooth, WinRT.

    Attributes:
        scanner: A class derived from ``bleak.backends.scanner.BaseBleakScanner``.
        client: A class derived from ``bleak.backends.client.BaseBleakClient``.
    """

    scanner: type[object]
    client: type[object]
