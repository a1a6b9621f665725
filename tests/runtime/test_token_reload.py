"""A reload: a token that was replaced opens no server any more."""

import aiohttp

from homebot.config import Config, parse_config
from homebot.runtime import Runtime


def config_with(token: str) -> Config:
    things = {"port": 0, "token": token}
    return parse_config({"thing_directory": things, "discovery": {"persist": False}}, "homebot.toml")


async def test_the_replaced_token_of_the_directory_of_things_is_refused_and_ends_its_streams() -> None:
    """The log says that tokens were reloaded; whoever replaces one has perhaps lost it."""
    tokens = "the-old-one-0123456789", "the-new-one-0123456789"
    old, new = ({"Authorization": f"Bearer {token}"} for token in tokens)
    async with (
        Runtime(config_with(tokens[0]), with_door=False) as runtime,
        aiohttp.ClientSession() as client,
    ):
        assert runtime._things is not None
        url = f"http://127.0.0.1:{runtime._things.port}"
        async with client.get(f"{url}/events", headers=old) as events:
            await runtime.reload(lambda: config_with(tokens[1]))
            assert (await events.read()).endswith(b"\n\n")
        for headers, status in ((old, 401), (new, 200)):
            async with client.get(f"{url}/things", headers=headers) as answer:
                assert answer.status == status
