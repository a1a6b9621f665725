"""Still pictures of a Home Assistant, over its HTTP: cameras, images such as maps, and covers of media.

Source: Home Assistant core 2024.3, ``components/camera``, ``image`` and ``media_player``: the views of their proxies.
"""

from typing import Final

import anyio.to_thread
from pydantic import SecretStr

from homebot.devices.picture_messages import MAX_PICTURE_BYTES
from homebot.errors import RefusedError
from homebot.gateways.password_settings import HttpLogin
from homebot.integrations.homeassistant.gateway.settings import HomeAssistantGatewaySettings
from homebot.plugins import check_extra

_PROXIES: Final = {"camera": "camera_proxy", "image": "image_proxy", "media_player": "media_player_proxy"}
_TIME_LIMIT: Final = 9.0


async def read_picture(settings: HomeAssistantGatewaySettings, domain: str, entity_id: str) -> bytes:
    """Return the newest picture of an entity.

    Raises:
        LinkError: Home Assistant does not answer in time.
        RefusedError: It has none.
        UsageError: aiohttp is missing, or the token cannot be read.
        WireError: It breaks the rules of HTTP, or the picture is too large.
    """
    if domain not in _PROXIES:
        raise RefusedError(f"a picture of {entity_id}", "it has none")
    check_extra("a picture of Home Assistant", "mdns", "aiohttp")
    from homebot.gateways.http_address import parse_url  # noqa: PLC0415 - an extra
    from homebot.gateways.http_client import HttpClient  # noqa: PLC0415 - likewise

    token = await anyio.to_thread.run_sync(settings.read_token)
    base = settings.websocket.replace("ws", "http", 1).removesuffix("/api/websocket")
    login = HttpLogin(str(parse_url(base).origin()), "bearer", "", SecretStr(token))
    async with HttpClient(guard=None, login=login, time_limit=_TIME_LIMIT, max_bytes=MAX_PICTURE_BYTES) as client:
        return (await client.get(f"{base}/api/{_PROXIES[domain]}/{entity_id}", accept="image/*")).body
