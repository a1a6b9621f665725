"""Zigbee2MQTT: Zigbee devices as the bridge itself lists them, without Home Assistant's discovery.

Reads and commands: lights, switches, valves, covers, locks, climate and fans with all endpoints; other exposes are
sensors, events or settings. A settable binary is a setting: *turn off everything* must not affect a child lock. Scenes
are parts. A group of lamps, switches or covers is a way to reach its members.

Transport: MQTT (``homebot.mqtt_conventions``): ``BASE/bridge/devices`` and ``bridge/groups`` in, states on
``BASE/NAME``, commands on ``BASE/NAME/set``; ``bases`` names several bridges. States are not retained, and asked for.
The bridge's announcements to Home Assistant are left out for listed devices, but ``suggested_area`` is the room.

Source: zigbee2mqtt.io, "MQTT topics and messages" and "Exposes"; Zigbee2MQTT 2.14.1; zigbee-herdsman-converters
26.105.0.

Tested against: real models as Zigbee2MQTT 2.14.1 lists them, with the answers of Home Assistant core 2025.4.4; both
announcements of each at once; and a simulated bridge (``dialect = "zigbee2mqtt"``).

Not done: requests to the bridge: to let devices join, to name, group or update them.
"""
