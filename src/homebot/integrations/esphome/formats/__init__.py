"""ESPHome's native API: the entities of a device, their reports and commands. Pure.

Source: ESPHome 2026.10, ``components/api/api.proto``.
"""
