"""Homie: the convention for MQTT, in its versions 3, 4 and 5, as Valetudo and many self-made devices use it.

Reads and commands: devices, their nodes and properties. With the types of the smart-home profile, or one of
their words, a node is a part with a known function; without, it is made of settings and readings by datatype and unit.
Names decide nothing, but what may be a lock by its name is one, and asks.

Transport: MQTT (``homebot.mqtt_conventions``), below ``homie/5/DEVICE`` or ``homie/DEVICE``; ``domains`` names others.

Source: Homie convention 5 (homieiot/convention, develop of October 2024), 4.0.0 and 3.0.1; hc-smarthome v2 and v1;
homie5-device-profiles, draft; Valetudo 2021.10 to 2025, ``backend/lib/mqtt``.

Tested against: messages of the library Homie4 0.4.0, the documents of convention 5, a robot by Valetudo that announces
itself to Home Assistant too, hostile documents, and simulated devices of Homie 5 (``dialect = "homie"``).

Not done: broadcasts to all devices, and the alerts of Homie 5, which are topics of their own.
"""
