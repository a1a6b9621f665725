"""The rights on Zenoh of a house and its robots, each of which has a token with its name and a secret."""

import json
from pathlib import Path

import zenoh
from pydantic import SecretStr

from homebot.bridges.rosbridge import ClientToken, RosbridgeSettings
from homebot.bridges.zenoh.rights import WireRights
from homebot.messages.interfaces.settings import RosSettings

HOME = "villa"


def secret_of(robot: str) -> str:
    return f"a secret of {robot}"


def door_of(*robots: str, scope: tuple[str, ...] = ("read", "act: harmless")) -> RosbridgeSettings:
    tokens = {one: ClientToken(token=SecretStr(secret_of(one)), scope=(*scope, f"robot: {one}")) for one in robots}
    return RosbridgeSettings(tokens=tokens)


def house_rights(settings: RosSettings, *machines: str) -> WireRights:
    secrets = {one: SecretStr(secret_of(one)) for one in machines}
    return WireRights.of_tokens(settings, door_of(*settings.imports), HOME, secrets, now=0.0)


def robot_rights(settings: RosSettings, robot: str) -> WireRights:
    return WireRights.of_routers(settings, HOME, (robot, SecretStr(secret_of(robot))))


def write_tokens(folder: Path, *robots: str) -> str:
    """Write the tokens of *robots*; return their tables for homebot.toml."""
    text = ""
    for one in robots:
        file = folder / f"{one}.token"
        file.touch(0o600)
        file.write_text(f"{secret_of(one)}\n")
        text += f'[door.tokens.{one}]\ntoken_file = "{file.name}"\nscope = ["read", "robot: {one}"]\n'
    return text


def log_in(
    address: str, robot: str = "", secret: str = "", ca: Path | None = None, *, patience: float = 0.0
) -> zenoh.Session:
    """Return a session of Zenoh alone, as a robot's program may have it; without a *robot*, it does not log in.

    Args:
        patience: Seconds for which it tries again; by default it tries once.

    Raises:
        zenoh.ZError: The router does not let it in.
    """
    login = {"user": robot, "password": secret or secret_of(robot)} if robot else {}
    config = {
        "mode": "client",
        "connect": {"endpoints": [address], "timeout_ms": int(patience * 1000)},
        "scouting": {"multicast": {"enabled": False}},
        "transport": {
            "auth": {"usrpwd": login},
            "link": {"tls": {"root_ca_certificate": ca and str(ca)}},
        },
    }
    return zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
