"""Tasmota: devices with this firmware, by its own discovery.

Reads and commands: relays, lights of all subtypes, shutters with tilt, iFan, switches and buttons, each value of each
sensor, and devices that sleep. A transition becomes Tasmota's speed, which depends on the state of the lamp.

Transport: MQTT (``homebot.mqtt_conventions``): ``tasmota/discovery/MAC/config`` and ``/sensors`` in, states on
``tele/…`` and ``stat/…``, commands on ``cmnd/…``.

Source: Tasmota 14.4 firmware, ``xdrv_12_discovery.ino``; tasmota.github.io/docs; hatasmota 0.10; Home Assistant core
2025.4, ``components/tasmota``; for names of values also ioBroker.sonoff 3.3 and evcc.

Tested against: devices written from the firmware's documentation, with the answers of Home Assistant core 2025.4.4 and
hatasmota 0.10.0 to the same messages; and simulated devices (``dialect = "tasmota"``).

Not done: repeating the last speed of a fan that is only told to be on; it runs at medium speed.
"""
