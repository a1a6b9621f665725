"""The engine for gateways whose devices are announced, whatever the protocol: sightings, reports, commands, texts."""
