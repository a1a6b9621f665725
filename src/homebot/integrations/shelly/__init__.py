"""Shelly: devices of both generations, and Bluetooth devices behind them.

Reads and commands: relays, rollers, lights, inputs, meters, sensors, add-ons, thermostats, irrigation zones as valves,
and values that users or makers define. A Bluetooth device behind a Shelly is a device of its own.

Transports: MQTT, both generations (``homebot.mqtt_conventions``); the WebSocket of each device of the second generation
and later, as a driver of the gateway ``mdns`` (``homebot.drivers``), by aiohttp, without a broker or a cloud. The
frames of both are alike, so one description serves both, and a device on both is one by its hardware address. Passwords
are sent only as SHA-256 digests. Devices are Bluetooth proxies of the gateway ``ble`` (``homebot.ble_proxies``) by the
script of aioshelly.

Source: Shelly Gen1 API; Shelly Gen2+ API; iobroker.shelly 12.0 and aioshelly for models; Home Assistant core 2025.11
and 2026.11, ``components/shelly``, for thermostats and strips.

Tested against: messages written from the API's documentation with the answers of the tables of iobroker.shelly 12.0;
answers of real models; and simulated devices (``dialect = "shelly"``, ``"shelly_rpc"``, ``"shelly_http"``), of which
aioshelly, the client of Home Assistant, takes those over HTTP for real ones (``peers`` of its tests).

Not done: over HTTP, the first generation is listed with model and firmware alone. BLU sensors that broadcast for
themselves are BTHome's.
"""
