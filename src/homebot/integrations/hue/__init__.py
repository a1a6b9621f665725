"""Philips Hue: bridges with the CLIP API v2, the square one since software 1948086000, and the Bridge Pro.

Reads and commands: lights, plugs, motion, temperature, light and contact sensors, rooms whose lights notice motion,
buttons, doorbells, dials, batteries; rooms, zones as tags, and the scenes and lights of both. Changes are pushed by the
bridge's stream of events; the bridge is asked every ten seconds whether it is still there.

Transport: HTTPS, as a gateway (``homebot.gateways``) by aiohttp. Bridges are found by the gateway ``mdns`` or named. A
press of the bridge's button pairs; its key and certificate are kept, and no other certificate is accepted. At most ten
commands a second go to lights and one to scenes and groups.

Source: Philips Hue, CLIP API v2, "Getting started" and its reference.

Tested against: a simulated bridge (``dialect = "hue"``), which aiohue, the client of Home Assistant, takes for real
(``peers`` of its tests); the contract of gateways. Not with products.

Not done: entertainment areas, cameras, chimes. A gradient light has one colour, that of its first point.
"""
