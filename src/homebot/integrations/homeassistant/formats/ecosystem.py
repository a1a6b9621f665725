"""Home Assistants on the network. Pure.

Source: Home Assistant core 2024.3, ``components/zeroconf/__init__.py``.
"""

from homebot.conventions.dns_sd import FoundService
from homebot.conventions.ecosystem import Ecosystem

_TOKEN = "a long-lived access token (in Home Assistant: your profile, Security)"  # noqa: S105 - none itself


class HomeAssistant(Ecosystem):
    """Servers."""

    service_types = frozenset({"_home-assistant._tcp.local."})
    gateway = "homeassistant"
    server = ("http", 8123)

    @classmethod
    def next_step(cls, service: FoundService) -> str:
        """Return the table of the gateway."""
        default = f"http://{service.host.rstrip('.')}:{service.port}"
        url = (service.properties.get("internal_url") or service.properties.get("base_url") or default)[:200]
        table = f'[gateways.homeassistant] with url = "{url}"'
        return f"if it is yours, add {table} and token_file, a file with {_TOKEN}"
