"""Things over CoAP: content formats, and devices that have no Thing Description. Pure."""
