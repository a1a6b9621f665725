"""A simulated Home Assistant with the devices of a house, and devices of its discovery over MQTT."""
