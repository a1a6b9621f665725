"""Home Assistant: devices that announce themselves to it over MQTT, and all devices of one, over its WebSocket.

Reads and commands, over MQTT: configs of components and of whole devices, with abbreviations, ``~``, availability,
removal and migration; all components, lights in all schemas. Many programs announce so: ESPHome, Zigbee2MQTT,
zwave-js-ui, OpenMQTTGateway, Valetudo. Templates run in a bounded subset of Jinja2 (``formats.jinja``). With
``publish``, homebot's exposed devices are announced to a Home Assistant.

Over the WebSocket: the registries of devices, entities, areas, floors and labels, states, service calls, events and
device triggers. A device that another gateway brought is one device.

Automations, in files, become routines of homebot (``homebot routine import``).

Transports: MQTT (``homebot.mqtt_conventions``); WebSocket with a token (``homebot.gateways``), by websockets.

Source: Home Assistant core 2025.4 to 2026.11, ``components/mqtt``, ``helpers``; core 2024.3,
``components/websocket_api``, ``components/config`` and the domains.

Tested against: Home Assistant itself, with all entities of its integration ``demo`` in 2024.3.3, by hand 2025.4.4 and
2026.11.0; messages of real products with the answers of 2025.4.4; the contract of gateways; and simulated devices
(``dialect = "homeassistant"``, ``"homeassistant_device"``, ``"home_assistant"``).

Not done: videos, calendars, weather, scripts, and the installation of software.
"""
