"""HomeKit accessories: their services and characteristics, as parts of devices. Pure."""
