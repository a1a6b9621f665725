"""ESPresense: phones and tags that its nodes hear by Bluetooth.

Reads: ``place`` of each device with a name, which is ``home`` while a node hears it, and unknown after two minutes of
silence. It never tells of a leave: after which silence that is certain, ``[people]`` says (``docs/people.md``).
While all nodes that ever heard it are offline, the device cannot be reached, and its silence means nothing.

Transport: MQTT, JSON on ``espresense/devices/ID/ROOM``, and ``espresense/rooms/ROOM/status``
(``homebot.mqtt_conventions``).

Source: ESPresense 4.0, ``lib/BleFingerprint/BleFingerprint.cpp`` (``fill``) and ``src/mqtt.cpp``.

Tested against: messages with the fields of that source, and hostile ones.

Not done: rooms and distances, devices without an alias (those of neighbours, as a rule, also with a name that they give
themselves), sensors of the nodes, settings.
It has no simulated devices.
"""
