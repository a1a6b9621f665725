"""Valetudo: the map of a robot vacuum, its rooms and where the robot is.

Reads: the segments, their names and the position, in metres, for the robot that names its topic: ``vacuum =
"valetudo/rosie"`` in ``[robots.rosie]`` (``docs/robots.md``). The robot as a device announces itself by Homie or to
Home Assistant, and is read by these integrations.

Transport: MQTT, JSON that is as a rule compressed by zlib (``homebot.vacuum_maps``).

Source: Valetudo 2026.08.0, ``backend/lib/entities/map``.

Tested against: maps of real robots (Dreame D9, Roborock S8, Viomi V6), pixel by pixel, and hostile ones.

Not done: everything on the map but segments and the robot. It has no simulated devices.
"""
