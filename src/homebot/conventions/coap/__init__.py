"""Formats of CoAP devices and resource directories: CBOR, links, endpoints and their registrations. Pure."""
