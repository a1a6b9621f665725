"""A gateway to lamps that are files: the same layout as ``homebot new integration`` writes, for another protocol.

Reads and commands: ``NAME.lamp`` has the state of a lamp, ``on`` or ``off``, ``NAME.set`` the last command to it. A
lamp is removed with its file. While the folder is missing, such as a disk that is unplugged, the gateway is unavailable
and keeps its lamps.

Transport: a folder, read ten times a second, as a gateway (``homebot.gateways``).

Tested against: the contract of gateways, and files in a running homebot.

Not done: brightness, and simulated lamps.
"""
