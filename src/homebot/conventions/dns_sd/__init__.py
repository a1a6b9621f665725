"""DNS-Based Service Discovery (RFC 6763): service types, TXT records, and the facts in them. Pure."""
