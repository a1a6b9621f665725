"""Matter, experimental: the nodes of a Matter server, which holds the fabric.

Reads and commands: each node as a device and each endpoint as a part with the type of its first known device type, and
bridged endpoints as devices of their own: lights, plugs, coverings, closures, locks, climate, fans, valves, buttons,
vacuum cleaners, sensors, alarms, meters; of other appliances mode, temperature and whether they run. Devices are
commissioned and removed by services of the gateway; no setup code is kept or logged.

Transport: the server's WebSocket, as a gateway (``homebot.gateways``) by aiohttp. The server has no password.

Source: Matter 1.4 Core Specification, Application Clusters and Device Library; Matter 1.5 for closures and chimes;
python-matter-server 8.1, schema versions 5 to 11.

Tested against: python-matter-server 8.1 with a light on matter.js (``peers`` of its tests), by hand 70 devices of
Matterbridge; recorded frames of a real server; the contract of gateways; and a simulated server (``dialect =
"matter"``, ``"matter_bridge"``, ``"matter_plug"``). Not with products, Thread or Bluetooth.

Not done: cameras, and vendors' own clusters but those of meters.
"""
