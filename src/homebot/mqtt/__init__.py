"""MQTT itself: packets, topics, clients and a broker, independent of homes and devices."""
