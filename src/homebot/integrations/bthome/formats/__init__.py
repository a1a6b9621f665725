"""BTHome v2: measurements and events that a device broadcasts by Bluetooth Low Energy. Pure.

Source: https://bthome.io/format and https://bthome.io/encryption, read in November 2026.
"""
