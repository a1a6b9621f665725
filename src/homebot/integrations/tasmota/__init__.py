"""tasmota."""
