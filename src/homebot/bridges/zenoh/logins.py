"""Logins of robots at the router, and tokens that do not suffice for one. Pure, without Zenoh."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import TYPE_CHECKING

from homebot.devices.client_rights import ALL_ROBOTS
from homebot.rights import Right
from homebot.words.rights import read_scope

if TYPE_CHECKING:
    from homebot.bridges.rosbridge import RosbridgeSettings
    from homebot.messages.interfaces.settings import RosSettings


def token_of(robot: str, rosbridge: RosbridgeSettings) -> str | None:
    """Return the name of the token of *robot*: the first with the right to be it; None without one."""
    return next(
        (name for name, settings in rosbridge.tokens.items() if robot in read_scope(settings.scope).robots), None
    )


def logins_of(settings: RosSettings, rosbridge: RosbridgeSettings) -> tuple[str, ...]:
    """Return the names with which robots log in at the address ``listen`` of *settings*."""
    names = (token_of(robot, rosbridge) for robot in settings.imports)
    return tuple(dict.fromkeys(name for name in names if name is not None))


def login_notes(settings: RosSettings, rosbridge: RosbridgeSettings) -> Iterator[str]:
    """Yield the lack of each robot that cannot log in at ``listen`` of *settings*, or would see nothing."""
    if not settings.listen:
        return
    logins = logins_of(settings, rosbridge)
    if not settings.imports:
        wanted = """import = {NAME = ["/NAME/**"]} in [ros], and a token with the right 'robot: NAME'"""
        yield f"no robot may log in at {settings.listen}; that takes {wanted}"
    for name, token in rosbridge.tokens.items():
        rights = read_scope(token.scope)
        robots = [robot for robot in rights.robots if robot != ALL_ROBOTS]
        if name in logins:
            if settings.export and not rights.has(Right.READ):
                yield f"{name} sees nothing of export at {settings.listen}: its token lacks the right read"
        elif robots:
            others = [login for login in map(partial(token_of, rosbridge=rosbridge), robots) if login in logins]
            why = f"{robots[0]} logs in as {others[0]}" if others else f"import of [ros] names no {' or '.join(robots)}"
            yield f"the token {name} is no login at {settings.listen}: {why}"
