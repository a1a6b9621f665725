"""zigbee2mqtt."""
