"""Bluetooth sensors of many makers, through the libraries that Home Assistant uses for their formats.

Reads: BTHome v1, Govee, Inkbird, Qingping, Ruuvi, SensorPush, ThermoPro, Xiaomi, and the sensors of every other
installed library that is based on ``bluetooth-sensor-state-data``. Its device classes and units are those of Home
Assistant. Xiaomi's encrypted devices need a bind key, in the table of the gateway.

Transport: advertisements, as a parser of the gateway ``ble`` (``homebot.ble_parsers``). The libraries come with
``homebot[ble-sensors]``, which ``homebot[all]`` lacks: they depend on habluetooth, and that on PyRIC, under the GPL.

Source: the libraries; the oldest versions in use are in ``pyproject.toml``, the extra ``ble-sensors``.

Tested against: advertisements of real devices, from the tests of xiaomi-ble, bthome-ble, govee-ble, inkbird-ble and
ruuvitag-ble, and from Home Assistant's for govee-ble.

Not done: values that a library would read over a connection. It has no simulated devices.
"""
