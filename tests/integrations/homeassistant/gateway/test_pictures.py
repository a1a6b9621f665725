"""Still pictures of a Home Assistant: cameras, images and covers, with its token, and nothing else."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from aiohttp import web
from tests.ports import reserve_port

from homebot.devices.picture_messages import picture_of
from homebot.errors import RefusedError
from homebot.integrations.homeassistant.gateway.pictures import read_picture
from homebot.integrations.homeassistant.gateway.settings import HomeAssistantGatewaySettings

PNG = b"\x89PNG\r\n\x1a\npicture"
ENTITIES = {"camera": "camera.porch", "image": "image.map", "media_player": "media_player.radio"}


@asynccontextmanager
async def home_assistant() -> AsyncIterator[str]:
    async def answer(request: web.Request) -> web.Response:
        if request.headers.get("Authorization") != "Bearer token-of-ours":
            raise web.HTTPUnauthorized
        is_picture = request.path in {f"/api/{domain}_proxy/{name}" for domain, name in ENTITIES.items()}
        return web.Response(body=PNG if is_picture else b"500: Internal Server Error")

    application = web.Application()
    application.router.add_get("/{path:.*}", answer)
    runner = web.AppRunner(application)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", port := reserve_port()).start()
    try:
        yield f"127.0.0.1:{port}"
    finally:
        await runner.cleanup()


@pytest.mark.parametrize("scheme", ["http://{}", "ws://{}/api/websocket"])
async def test_pictures_come_with_the_token_and_other_entities_have_none(
    monkeypatch: pytest.MonkeyPatch, scheme: str
) -> None:
    monkeypatch.setenv("HA_TOKEN", "token-of-ours")
    async with home_assistant() as place:
        settings = HomeAssistantGatewaySettings(url=scheme.format(place), token_env="HA_TOKEN")
        for domain, name in ENTITIES.items():
            found = picture_of(name, await read_picture(settings, domain, name))
            assert (found.media_type, found.data) == ("image/png", PNG)
        for domain, name in (("camera", "camera.broken"), ("light", "light.hall")):
            with pytest.raises(RefusedError, match=r"it is no JPEG|it has none"):
                picture_of(name, await read_picture(settings, domain, name))
