"""The Bluetooth stack of a gateway, as a service of its host."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, eq=False)
class BleBackend:
    """The two classes through which bleak uses a Bluetooth stack; see ``backend=`` of its scanner and client.

    Without this service the gateway uses bleak's defaults: BlueZ, CoreBluetooth, WinRT.

    Attributes:
        scanner: A class derived from ``bleak.backends.scanner.BaseBleakScanner``.
        client: A class derived from ``bleak.backends.client.BaseBleakClient``.
    """

    scanner: type[object]
    client: type[object]
