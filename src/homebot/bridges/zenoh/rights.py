"""The rights of others on Zenoh: logins, and the messages that pass; all others are dropped."""

from __future__ import annotations

import secrets
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import chain, combinations, product
from typing import TYPE_CHECKING, Final, NamedTuple, Self, TypeAlias

import zenoh

from homebot.bridges.zenoh.bridge_tokens import ALL_BRIDGE_TOKENS, BRIDGED_ENTITY, CACHE, READ_KINDS, SLASH
from homebot.bridges.zenoh.logins import token_of
from homebot.bridges.zenoh.tokens import ALL_TOKENS
from homebot.devices.client_rights import OWNER_CLIENT
from homebot.errors import UsageError
from homebot.names import escape_token
from homebot.rights import Right
from homebot.words.rights import read_scope

if TYPE_CHECKING:
    from pydantic import SecretStr

    from homebot.bridges.rosbridge import RosbridgeSettings
    from homebot.messages.interfaces.settings import RosSettings

_Words: TypeAlias = tuple[str, ...]

_FROM, _TO = ("ingress",), ("egress",)
_GIVE: Final = ("put", "delete", "declare_queryable", "reply", "liveliness_token")
"""Messages of the nodes that have a topic or service."""

_TAKE: Final = ("declare_subscriber", "query", "declare_liveliness_subscriber", "liveliness_query")
"""Messages of the nodes that use it."""

_EVERYTHING: Final = ("**", "**/@adv/**", "@ros2_lv/**", ALL_BRIDGE_TOKENS, CACHE.format(session="*", key="**"))
_ENTITY: Final = "@ros2_lv/{domain}/*/*/*/{kind}/*/{node}/{rest}"
_OWN_NODE: Final = "%/ros2"


class WireRule(NamedTuple):
    """Messages that pass.

    Attributes:
        user: Their sender or receiver; empty for any.
        flows: ``ingress`` for messages from the user, ``egress`` for those to the user.
        messages: Their kinds, in Zenoh's words.
        keys: Their topics and services, as key expressions.
    """

    user: str
    flows: _Words
    messages: _Words
    keys: _Words


@dataclass(frozen=True, slots=True)
class WireRights:
    """The rights of others in a session.

    Attributes:
        passwords: The passwords of logins at this router, by user.
        login: The user and password with which it logs in at other routers; None for none.
    """

    rules: tuple[WireRule, ...]
    passwords: Mapping[str, SecretStr] = field(default_factory=dict)
    login: tuple[str, SecretStr] | None = None

    @classmethod
    def of_tokens(
        cls,
        settings: RosSettings,
        rosbridge: RosbridgeSettings,
        home: str,
        machines: Mapping[str, SecretStr],
        now: float,
        owner: SecretStr | None = None,
    ) -> Self:
        """Return the rights at the router of *home*: of each robot those of its token in *rosbridge*, all of the owner.

        A robot whose token is missing, or has ended at *now*, may not log in. Other machines of the house, with their
        secrets by name, have what is below ``/HOME/MACHINE``.

        Raises:
            UsageError: A machine has the name of a token.
        """
        passwords = {name: password for name, password in rosbridge.all_tokens(owner).items() if name == OWNER_CLIENT}
        rules = [WireRule(name, _FROM + _TO, _GIVE + _TAKE, _EVERYTHING) for name in passwords]
        for name, secret in machines.items():
            passwords[name] = secret
            rules.append(WireRule(name, _FROM + _TO, _GIVE + _TAKE, (*_keys(settings.domain, (_below(home, name),)),)))
        for robot in settings.imports:
            token = token_of(robot, rosbridge)
            if token in machines:
                raise UsageError(f"a machine and a token are both called {token}; give one of them another name")
            if token is not None and now < rosbridge.tokens[token].until:
                passwords[token] = rosbridge.tokens[token].token
                rules += _rules_of(
                    token, robot, settings, reads=read_scope(rosbridge.tokens[token].scope).has(Right.READ)
                )
        return cls(tuple(rules), passwords)

    @classmethod
    def of_routers(cls, settings: RosSettings, home: str, login: tuple[str, SecretStr] | None) -> Self:
        """Return the rights of the routers that homebot connects to: nothing passes from one to another."""
        tokens = ALL_TOKENS.format(domain=settings.domain)
        names, machines = [*chain.from_iterable(settings.imports.values())], _below(home)
        imported = (*_keys(settings.domain, (*names, machines)), tokens, *_bridge_keys(names), ALL_BRIDGE_TOKENS)
        exported = (*_keys(settings.domain, (*settings.export, machines)), tokens)
        rules = (
            WireRule("", _FROM, _GIVE, imported),
            WireRule("", _TO, _TAKE, imported),
            WireRule("", _TO, _GIVE, exported),
            WireRule("", _FROM, _TAKE, exported),
        )
        return cls(rules, login=login)

    def dictionary(self) -> str:
        """Return the users with their passwords, as in Zenoh's file: without one, everybody could connect."""
        known = {user: password.get_secret_value() for user, password in self.passwords.items()}
        return "".join(
            f"{user}:{password}\n" for user, password in (known or {"nobody": secrets.token_urlsafe()}).items()
        )

    def access_control(self) -> dict[str, object]:
        """Return the rules as Zenoh's configuration."""
        rules = [rule for rule in self.rules if rule.keys]
        users = [{"usernames": [rule.user]} if rule.user else {} for rule in rules]
        ids = [{"id": str(number)} for number in range(len(users))]
        return {
            "enabled": True,
            "default_permission": "deny",
            "rules": [
                {**name, "permission": "allow", "flows": rule.flows, "messages": rule.messages, "key_exprs": rule.keys}
                for name, rule in zip(ids, rules, strict=True)
            ],
            "subjects": [{**name, **user} for name, user in zip(ids, users, strict=True)],
            "policies": [{"rules": [name["id"]], "subjects": [name["id"]]} for name in ids],
        }


def _rules_of(user: str, robot: str, settings: RosSettings, *, reads: bool) -> Iterator[WireRule]:
    domain = settings.domain
    names = settings.imports[robot]
    own = (*_keys(domain, names), *_tokens(robot, settings), *_bridge_keys(names), *_bridge_tokens(names))
    yield WireRule(user, _FROM + _TO, _GIVE + _TAKE, own)  # its programs have each other's too
    yield WireRule(user, _FROM + _TO, _TAKE, (ALL_TOKENS.format(domain=domain),))
    yield WireRule(user, _TO, _TAKE, (ALL_BRIDGE_TOKENS,))
    if reads:
        exported = tuple(_keys(domain, settings.export))
        spaces = (name.rpartition("/") for name in settings.export)
        nodes = (_OWN_NODE, *(f"{_chunk(space) or '%'}/{_chunk(node)}" for space, _, node in spaces))
        tokens = (_ENTITY.format(domain=domain, kind="*", node=node, rest="**") for node in nodes)
        yield WireRule(user, _TO, _GIVE, (*exported, *tokens))
        yield WireRule(user, _FROM, _TAKE, exported)


def _tokens(robot: str, settings: RosSettings) -> Iterator[str]:
    """Yield the tokens of *robot*, whose nodes are below its name if there are others."""
    nodes = ("*/*",) if len(settings.imports) == 1 else (f"%{robot}/*", f"%{robot}%$*/*", f"%/{robot}")
    names = [f"{_chunk(name)}{rest}/**" for name in settings.imports[robot] for rest in ("", "%_action%$*")]
    given = [(kind, name) for kind in ("MP", "SS") for name in names]
    for node, (kind, rest) in product(nodes, [("NN", "**"), ("MS", "**"), ("SC", "**"), *given]):
        yield _ENTITY.format(domain=settings.domain, kind=kind, node=node, rest=rest)


def _keys(domain: int, names: Iterable[str]) -> Iterator[str]:
    """Yield the keys of the topics, services and actions *names*, and of what Zenoh has for their late readers."""
    for name in names:
        for rest in ("", "/_action/*"):
            key = str(zenoh.KeyExpr.autocanonize(f"{domain}/{_parts(name)}{rest}/*/*"))
            yield from (key, f"{key}/@adv/**")


def _bridge_keys(names: Iterable[str]) -> Iterator[str]:
    """Yield the keys of *names* behind zenoh-bridge-ros2dds, and of what it and Zenoh have for late readers."""
    for name, rest in product(_bridged(names), ("", "/_action/*")):
        key = str(zenoh.KeyExpr.autocanonize(f"{_parts(name)}{rest}"))
        yield from (key, f"{key}/@adv/**", CACHE.format(session="*", key=key))


def _bridge_tokens(names: Iterable[str]) -> Iterator[str]:
    for name, kind in product(_bridged(names), READ_KINDS):
        yield BRIDGED_ENTITY.format(kind=kind, name=_chunk(name[1:], SLASH))


def _bridged(names: Iterable[str]) -> Iterator[str]:
    """Yield those of *names* that robots behind a bridge may have: their keys begin with no domain.

    Others would be the keys of rmw_zenoh too, which begin with one.
    """
    for name in names:
        first = name.split("/")[1]
        if "*" not in first and not first[0].isdigit():
            yield name


def _parts(pattern: str) -> str:
    """Return *pattern* as parts of a key."""
    return "/".join(part if part == "**" else _chunk(part) for part in pattern.split("/")[1:])


def _chunk(pattern: str, slash: str = "%") -> str:
    """Return *pattern* as one part of a token."""
    text = pattern.replace("/", slash).replace("**", "*")
    return text if text == "*" else text.replace("*", "$*")


def _below(*names: str) -> str:
    return f"/{'/'.join(map(escape_token, names))}/**"


def check_apart(settings: RosSettings) -> None:
    """Check that no name is imported of two robots: nothing would tell the sender of a message.

    Raises:
        UsageError: One is.
    """
    for (robot, names), (other, others) in combinations(settings.imports.items(), 2):
        for name, second in product(names, others):
            one, two = _keys(settings.domain, (name,)), _keys(settings.domain, (second,))
            if zenoh.KeyExpr(next(one)).intersects(zenoh.KeyExpr(next(two))):
                raise UsageError(
                    f"{name} of {robot} and {second} of {other} have names in common, of which nothing "
                    f"would tell whose they are; import those below /{robot} and /{other}"
                )
