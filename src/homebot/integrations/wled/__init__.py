"""WLED: controllers of LED strips, version 0.13 and later.

Reads and commands: brightness, colours, colour temperature and effects. A controller with one segment is one lamp; with
several, the controller is a lamp that can be dimmed, and each segment another.

Transport: HTTP and a WebSocket, as a driver of the gateway ``mdns`` (``homebot.drivers``) for each ``_wled._tcp``, by
aiohttp. Changes are pushed over the WebSocket; a controller without one, or without room for another client, is asked
every ten seconds. Commands go by HTTP, because the WebSocket does not acknowledge them. It has no settings.

Source: WLED, JSON API and WebSocket, https://kno.wled.ge/interfaces/json-api and /websocket, 0.13 to 16.

Tested against: documents in the forms of 0.13 to 0.15; and simulated controllers (``dialect = "wled"``), which the
official client takes for real ones (``peers`` of its tests).

Not done: palettes, and presets and playlists as commands. ``color_temperature`` has steps of 32 K from 1900 K on.
"""
