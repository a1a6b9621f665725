"""VDA 5050: mobile robots of a fleet, of any maker.

Reads: whether a robot is free, works, waits, charges, is driven by hand or cannot go on; the node where it stands, and
the one that it heads for; its battery, errors and emergency stop; its position in metres on its map.

Commands: the ``destination`` of a free robot is an order of two nodes, the one where it stands and one of ``nodes`` in
the table of this convention. Its ``option`` pauses (``paused``), goes on (``working``), cancels the order (``idle``)
and charges (``charging``: an order to ``charger``, or where it stands). The next state of the robot confirms or refuses
them. A robot of the house by its ``topic`` has the actions ``navigate_to_pose`` and ``dock_robot`` by the same ways.

Transport: MQTT, JSON on ``uagv/v2/MANUFACTURER/SERIAL/…`` or ``vda5050/v3/…`` (``homebot.mqtt_conventions``);
``interfaces`` in the table names other first levels.

Source: VDA 5050 2.0, 2.1 and 3.0, github.com/VDA5050/VDA5050, with its JSON schemas.

Tested against: the robot and the validators of vda-5050-lib 1.4, the schemas of vda5050-sdk 0.2, and hostile messages.

Not done: routes of several nodes, updates of an order, loads, zones and maps. It has no simulated devices.
"""
