"""The layout of the thesis that homebot began with: devices of plain text. The smallest integration; the one to copy.

Reads and commands: ``HOME/SERVICE_TYPE/DEVICE/out`` has the state of a device, such as ``on``, ``0.4`` or ``21.5``, and
``…/in`` takes commands as text. The service type is the device type; an ambiguous one is controllable: ``windows`` have
motors. The first message adds a device, an empty one removes it. A topic of the home with a wrong number of levels is
reported as an error.

Transport: MQTT (``homebot.mqtt_conventions``), without announcements. ``root`` in its table names the home.

Source: ``docs/house.md``, the table of devices.

Tested against: the house of the thesis, and simulated devices of all kinds (``dialect = "thesis"``, the default).

Not done: names, rooms, and whether a device can be reached: the layout has none of them.
"""
