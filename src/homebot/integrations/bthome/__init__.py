"""BTHome v2: sensors and buttons that broadcast by Bluetooth Low Energy, such as Shelly BLU and self-made ones.

Reads: measurements, conditions, and the events of buttons and dimmers, plain and encrypted, with a bind key for each
device in the table of the gateway. Repeated and late packets are told apart by their ids. The counter of encrypted
packets must increase, against replays.

Transport: advertisements, as a parser of the gateway ``ble`` (``homebot.ble_parsers``). Encryption needs the library
``cryptography``, of ``homebot[ble]``.

Source: https://bthome.io/format and https://bthome.io/encryption, read in November 2026.

Tested against: ``bthome-ble``, the parser of Home Assistant, packet by packet; the examples of the specification; and
simulated sensors on a virtual radio (``dialect = "bthome"``).

Not done: BTHome v1, which :mod:`homebot.integrations.sensor_libraries` reads. Devices that only broadcast take no
commands. A packet recorded before a restart may be read after it.
"""
