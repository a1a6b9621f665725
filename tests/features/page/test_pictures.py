"""Pictures of cameras for the page: at an address of the owner, on a topic; bounded, fetched once for all screens."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from aiohttp import web
from tests.ports import reserve_port

from homebot.config import parse_config
from homebot.devices.picture_messages import MAX_PICTURE_BYTES, GetPicture, PictureRequest, PictureResponse
from homebot.errors import ConfigError
from homebot.features.page import GET_PICTURE, LIST_PICTURES
from homebot.features.page.messages import ListPictures, PictureNamesRequest
from homebot.features.page.pictures import read_pictures
from homebot.graph import Node
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions
from homebot.runtime import Runtime

JPEG = b"\xff\xd8\xff\xe0picture"
PASSWORD = "correct-horse"


@asynccontextmanager
async def camera() -> AsyncIterator[tuple[str, list[str]]]:
    """A camera with pictures, and other things at its address; yields the address and the requests."""
    asked: list[str] = []

    async def answer(request: web.Request) -> web.Response:
        asked.append(f"{request.path} {request.headers.get('Authorization', '')}".strip())
        match request.path:
            case "/picture":
                return web.Response(body=JPEG, content_type="image/jpeg")
            case "/page":
                return web.Response(body=b"<html><script>alert(1)</script>", content_type="image/jpeg")
            case "/huge":
                return web.Response(body=JPEG + bytes(MAX_PICTURE_BYTES))
            case _:
                raise web.HTTPFound("http://localhost:1/secret")

    application = web.Application()
    application.router.add_route("GET", "/{path}", answer)
    runner = web.AppRunner(application)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", port := reserve_port()).start()
    try:
        yield f"http://127.0.0.1:{port}", asked
    finally:
        await runner.cleanup()


@asynccontextmanager
async def asking(tables: dict[str, object], services: tuple[HostedBroker, ...] = ()) -> AsyncIterator[Node]:
    async with (
        Runtime(parse_config(tables, "test"), services=services) as runtime,
        Node(runtime.graph, "asker") as node,
    ):
        await node.create_client(ListPictures, LIST_PICTURES.name).wait_for_service(5)
        yield node


async def picture(node: Node, device: str) -> PictureResponse:
    return await node.create_client(GetPicture, GET_PICTURE.name).call(PictureRequest(device=device), 20)


async def test_a_picture_at_an_address_of_the_owner_is_fetched_once_for_all_screens(tmp_path: Path) -> None:
    (secret := tmp_path / "password").write_text(PASSWORD)
    secret.chmod(0o600)
    async with camera() as (address, asked):
        rows = {
            "Porch": {"url": f"{address}/picture?x=1", "user": "me", "password_file": str(secret)},
            "Page": {"url": f"{address}/page"},
            "Huge": {"url": f"{address}/huge"},
            "Elsewhere": {"url": f"{address}/other"},
            "Off": {"url": f"http://127.0.0.1:{reserve_port()}/picture?key={PASSWORD}"},
        }
        async with asking({"pictures": rows}) as node:
            names = await node.create_client(ListPictures, LIST_PICTURES.name).call(PictureNamesRequest())
            assert names.names == tuple(rows)
            found: list[PictureResponse] = []

            async def look() -> None:
                found.append(await picture(node, "porch"))

            async with anyio.create_task_group() as tasks:
                for _ in range(5):
                    tasks.start_soon(look)
            assert {(one.success, one.media_type, one.data) for one in found} == {(True, "image/jpeg", JPEG)}
            assert asked == ["/picture Basic bWU6Y29ycmVjdC1ob3JzZQ=="]
            wrong = {name: (await picture(node, name)).message for name in ("Page", "Huge", "Elsewhere", "Off", "None")}
    assert "no JPEG, PNG, GIF or WebP" in wrong["Page"]
    assert "more than 2097152 bytes" in wrong["Huge"]
    assert "redirects to another host" in wrong["Elsewhere"]
    assert "127.0.0.1" in wrong["Off"]
    assert PASSWORD not in "".join(wrong.values())
    assert wrong["None"] == "there is no device or picture 'None'"


@pytest.mark.rooms("homeassistant")
async def test_a_camera_of_mqtt_has_the_picture_of_its_topic(tmp_path: Path) -> None:
    config = (
        b'{"topic": "cam/picture", "unique_id": "cam", "name": null, "device": {"identifiers": ["cam"], "name": "Cam"}}'
    )
    async with MemoryBroker() as broker:
        options = MqttOptions.from_url(broker.url, client_id="cam")
        async with (
            MqttConnection(options, broker.make_client, status_topic=None) as connection,
            asking({"gateways": {"mqtt": {"url": broker.url}}}, (HostedBroker.in_memory(broker),)) as node,
        ):
            await connection.wait_connected()
            await connection.publish("homeassistant/camera/cam/config", config, qos=1, retain=True)
            await connection.publish("cam/picture", JPEG + bytes(600_000), qos=1, retain=True)  # larger than any state
            found = PictureResponse(success=False, message="")
            for _ in range(200):
                if not found.success:  # until it is announced
                    await anyio.sleep(0.1)
                    found = await picture(node, "cam")
    assert (found.media_type, len(found.data)) == ("image/jpeg", len(JPEG) + 600_000)


@pytest.mark.parametrize("url", ["ftp://camera/picture", "http://me:secret@camera/", "picture.jpg", ""])
def test_what_is_no_address_of_a_picture_is_refused(url: str) -> None:
    with pytest.raises(ConfigError, match=r"the address of a picture is written like"):
        read_pictures(parse_config({"pictures": {"porch": {"url": url}}}, "test"))
