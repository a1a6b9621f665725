"""SwitchBot: the broadcasts of its devices by Bluetooth Low Energy.

Reads: sensors of climate, contact, motion, presence and leaks, and the states of locks, plugs, relays, curtains,
blinds, garage doors and bots, with the charge of batteries.

Transport: advertisements, as a parser of the gateway ``ble`` (``homebot.ble_parsers``).

Source: pySwitchbot 3.1, ``adv_parser.py`` and ``adv_parsers``.

Tested against: the bytes that pySwitchbot 3.1 describes, and any other bytes.

Not done: commands. The connections by which the devices take them are not used. It has no simulated devices.
"""
