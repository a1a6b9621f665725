"""Matter's nodes on the network, and their codes. Pure.

Source: Matter core specification 1.4, section 4.3 (discovery).
"""

from homebot.conventions.dns_sd import FoundService
from homebot.conventions.ecosystem import Ecosystem
from homebot.integrations.matter.formats.setup_code import read_matter_code

_NODE = "_matter._tcp.local."


class Matter(Ecosystem):
    """Nodes, those that can be commissioned, and their commissioners."""

    service_types = frozenset({_NODE, "_matterc._udp.local.", "_matterd._udp.local."})
    name_key = "dn"
    code_prefix = "MT:"
    read_code = staticmethod(read_matter_code)

    @classmethod
    def declared(cls, service: FoundService) -> tuple[str, ...] | None:
        """Return the identifier of a node in its fabric, as Home Assistant spells it."""
        is_node = service.service_type == _NODE
        return (f"matter:deviceid_{service.name.upper()}-MatterNodeDevice",) if is_node else None
