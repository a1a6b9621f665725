"""The engine for gateways of announced devices, for any protocol: sightings, reports, commands, texts."""
