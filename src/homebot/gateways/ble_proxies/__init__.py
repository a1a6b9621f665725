"""Receivers of Bluetooth in other rooms, which hear and connect for the gateway ``ble``."""
