"""Packets of multicast DNS, byte by byte: what no library would send (RFC 1035, section 4.1)."""

import socket
import struct

PTR, TXT, AAAA, SRV, A = 12, 16, 28, 33, 1


def name_of(text: str) -> bytes:
    """A domain name; the first label may have dots, as those of services do."""
    instance, underscore, rest = text.partition("._")
    labels = [instance, *f"_{rest}".rstrip(".").split(".")] if underscore else text.rstrip(".").split(".")
    encoded = [label.encode()[:63] for label in labels if label]
    return b"".join(bytes([len(label)]) + label for label in encoded) + b"\0"


def record(name: str, kind: int, data: bytes, ttl: int = 120, *, unique: bool = True) -> bytes:
    """A record; a unique one replaces others of its name and kind."""
    return name_of(name) + struct.pack("!HHIH", kind, 0x8001 if unique else 1, ttl, len(data)) + data


def pointer(service_type: str, name: str, ttl: int = 4500) -> bytes:
    """A PTR record: a service is there."""
    return record(service_type, PTR, name_of(name), ttl, unique=False)


def service(name: str, host: str, port: int, ttl: int = 120) -> bytes:
    """An SRV record: where it is."""
    return record(name, SRV, struct.pack("!HHH", 0, 0, port) + name_of(host), ttl)


def text(name: str, data: bytes, ttl: int = 4500) -> bytes:
    """A TXT record."""
    return record(name, TXT, data, ttl)


def address(host: str, ip: str, ttl: int = 120) -> bytes:
    """An A record."""
    return record(host, A, socket.inet_aton(ip), ttl)


def answer(*records: bytes) -> bytes:
    """A response with these records."""
    return struct.pack("!HHHHHH", 0, 0x8400, 0, len(records), 0, 0) + b"".join(records)
