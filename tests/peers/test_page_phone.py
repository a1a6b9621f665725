"""The page on a phone in the house: touched, over TLS by a proxy under a name of the owner's, with a token."""

import ssl
from collections.abc import AsyncIterator, Iterator
from contextlib import asynccontextmanager, suppress
from typing import Any

import anyio
import pytest
import trustme
from anyio import to_thread
from anyio.abc import ByteStream, SocketAttribute
from anyio.streams.tls import TLSListener
from tests.peers.chromium import NAME, Page, chromium

from homebot.config import parse_config
from homebot.house import thesis_world
from homebot.runtime import Runtime

SWITCH = ".tile [role=switch][aria-label*=philips165]"
TOKEN = "hunter2-and-some-more"


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as driver:
        yield driver


@asynccontextmanager
async def phone(browser: Any) -> AsyncIterator[Page]:
    """A phone whose browser knows a running homebot by the address of the proxy before it."""
    tls = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    await to_thread.run_sync(lambda: trustme.CA().issue_cert(NAME).configure_cert(tls))
    async with await anyio.create_tcp_listener(local_host="127.0.0.1") as listener, anyio.create_task_group() as tasks:
        origin = f"https://{NAME}:{listener.extra(SocketAttribute.local_port)}"  # noqa: S610 - of anyio
        door = {"port": 0, "token": TOKEN, "allowed_origins": [origin]}
        gateways = {"mqtt": {"root": "home425"}}
        config = parse_config({"home": {"name": "villa"}, "door": door, "gateways": gateways}, "test")
        async with Runtime(config, house=thesis_world(), robot="robot") as runtime:
            assert runtime.rosbridge is not None
            port = runtime.rosbridge.port

            async def forward(client: ByteStream) -> None:
                async with client:
                    with suppress(OSError):  # the page's worker still loads files when homebot has ended
                        server = await anyio.connect_tcp("127.0.0.1", port)
                        async with server, anyio.create_task_group() as both:
                            both.start_soon(copy, client, server)
                            await copy(server, client)
                            both.cancel_scope.cancel()

            tasks.start_soon(TLSListener(listener, tls, standard_compatible=False).serve, forward)
            own = Page(browser, runtime.rosbridge)
            own.url = f"{origin}/"
            own.become_phone()
            try:
                yield own
            finally:
                browser.execute_script("sessionStorage.clear(); localStorage.clear()")
                browser.get("about:blank")
                own.become_computer()
        tasks.cancel_scope.cancel()


async def copy(source: ByteStream, sink: ByteStream) -> None:
    try:
        async for chunk in source:
            await sink.send(chunk)
    except (anyio.BrokenResourceError, anyio.EndOfStream):  # the latter by TLS, if its reader has closed
        return


async def test_a_phone_logs_in_turns_a_lamp_on_and_stays_logged_in(browser: Any) -> None:
    async with phone(browser) as own:
        await own.open(shows="a valid token is needed")
        await own.tap("input[type=password]")
        await own.write("input[type=password]", "wrong")
        await own.tap("form button")
        await own.shows("a valid token is needed")
        await own.write("input[type=password]", TOKEN)
        await own.tap("label:has(input[name=remember])")
        await own.tap("form button")
        await own.shows("3 devices")
        await own.tap(f"{SWITCH}[aria-checked=false]")
        await own.shows("confirmed after", "[role=alert]")
        for view in ("security", "home"):
            await own.tap(f"nav a[href='#/{view}']")
        assert await to_thread.run_sync(own.overflow) == 0
        await to_thread.run_sync(browser.execute_script, "sessionStorage.clear()")  # as in a new tab
        await own.open(shows="3 devices")
        await own.open("#/more", shows="English")
        await own.tap(".screen button")
        await own.shows("a valid token is needed")
        assert own.problems() == []


async def test_an_address_with_the_token_logs_a_phone_in_and_does_not_keep_it(browser: Any) -> None:
    async with phone(browser) as own:
        await own.open(f"#token={TOKEN}", shows="3 devices")
        assert TOKEN not in browser.current_url
        await own.tap(f"{SWITCH}[aria-checked=false]")
        await own.shows("confirmed after", "[role=alert]")
