"""ESPHome: the entities of firmware with ``api:`` in its configuration, over its native API.

Reads and commands: all entities but cameras, infrared and radio transmitters, and those that are disabled by default.
Device classes, units and categories mean what they mean in Home Assistant. States are pushed; a device that is silent
for 26 seconds is unreachable, and one with ``deep_sleep:`` sleeps.

Transport: TCP with Noise encryption or without, by the library aioesphomeapi, as a driver of the gateway ``mdns``
(``homebot.drivers``) for each ``_esphomelib._tcp``. A password of old firmware is sent only to the address that the
owner allows. ESPHome over MQTT is read by Home Assistant's discovery instead. Its Bluetooth proxies
(``homebot.ble_proxies``) work for the gateway ``ble``, by the library bleak-esphome.

Source: ESPHome 2026.10, ``components/api/api.proto`` and the components named in the modules.

Tested against: ESPHome's own firmware, compiled for the platform ``host`` and without encryption (``peers`` of its
tests); and simulated devices (``dialect = "esphome"``), which are real servers of the native API, with encryption.

Not done: voice assistants, custom actions, proxies with firmware before 2023.6.
"""
