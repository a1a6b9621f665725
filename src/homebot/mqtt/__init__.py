"""MQTT itself: packets, topics, a client port and a broker; nothing of homes or devices in it."""
