"""Component of Home Assistant for tests: makes a token for homebot, and keeps it in the file ``token``."""

from datetime import timedelta
from pathlib import Path
from typing import Any

from homeassistant.auth.const import GROUP_ID_ADMIN
from homeassistant.core import HomeAssistant, ServiceCall
from homeassistant.helpers import entity_registry

NAME = "homebot"


async def async_setup(hass: HomeAssistant, _config: dict[str, Any]) -> bool:
    """Make a user with a token, once, and the service that revokes it."""
    file = Path(hass.config.path("token"))
    if not any(one.name == NAME for one in await hass.auth.async_get_users()):
        user = await hass.auth.async_create_user(NAME, group_ids=[GROUP_ID_ADMIN])
        token = await hass.auth.async_create_refresh_token(
            user,
            client_name=NAME,
            token_type="long_lived_access_token",
            access_token_expiration=timedelta(days=1),
        )
        file.touch(mode=0o600)
        file.write_text(hass.auth.async_create_access_token(token))

    async def revoke(_call: ServiceCall) -> None:
        for user in await hass.auth.async_get_users():
            for token in [one for one in user.refresh_tokens.values() if user.name == NAME]:
                hass.auth.async_remove_refresh_token(token)

    async def rename(call: ServiceCall) -> None:
        entity_registry.async_get(hass).async_update_entity(**call.data)

    async def remove(call: ServiceCall) -> None:
        entity_registry.async_get(hass).async_remove(call.data["entity_id"])

    for service in (revoke, rename, remove):
        hass.services.async_register("homebot_peer", service.__name__, service)
    return True
