"""HomeKit: accessories and bridges for Apple Home, with homebot as their controller.

Reads and commands: each accessory as a device, also behind a bridge, and each known service as a part: lights, plugs,
switches, fans, climate, locks, doors, windows, coverings, valves, security systems, speakers, televisions, buttons,
sensors. Changes are pushed; all values are read every 30 seconds, of a sleeping accessory every 5 minutes.

Transport: HTTP over IP, and CoAP over Thread, by the library aiohomekit. A gateway (``homebot.gateways``) of its own,
which follows the sightings of the gateway ``mdns``. The keys of pairings are in a file that only its owner reads; setup
codes are forgotten.

Source: HomeKit Accessory Protocol Specification, Non-Commercial Version, Release R2.

Tested against: HAP-python, as an accessory in a process of its own (``peers`` of its tests); over Thread a simulated
accessory; the contract of gateways; and the simulated bridge (``dialect = "homekit"``), by HAP-python too. Not with
products.

Not done: Bluetooth, because aiohomekit scans by itself, which BlueZ refuses; timed writes over Thread; cameras; most
vendors' characteristics.
"""
