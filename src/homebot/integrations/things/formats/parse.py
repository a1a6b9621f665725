"""The parser of Thing Descriptions, which checks the rules of TD 1.1. Pure.

Missing terms have the defaults of the specification, and unknown ones are ignored. Descriptions of version 1.0 are read
too.
"""

import re
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Final, get_args
from urllib.parse import unquote, urlsplit

from homebot.integrations.things.formats.fields import Fields
from homebot.integrations.things.formats.thing import (
    OBSERVE_OPS,
    WRITE_OPS,
    Affordance,
    AffordanceKind,
    DataSchema,
    DataType,
    Form,
    Thing,
)
from homebot.support.addresses import resolve_uri

CONTEXT: Final = "https://www.w3.org/2022/wot/td/v1.1"
_CONTEXTS = frozenset({CONTEXT, "https://www.w3.org/2019/wot/td/v1", "http://www.w3.org/ns/td"})

_KINDS: Mapping[str, AffordanceKind] = {"properties": "property", "actions": "action", "events": "event"}
_OPS: Mapping[AffordanceKind, tuple[str, ...]] = {
    "property": ("readproperty", "writeproperty", "observeproperty", "unobserveproperty"),
    "action": ("invokeaction", "queryaction", "cancelaction"),
    "event": ("subscribeevent", "unsubscribeevent"),
}
_DEFAULT_OPS: Mapping[AffordanceKind, tuple[str, ...]] = {
    "property": ("readproperty", "writeproperty"),
    "action": ("invokeaction",),
    "event": ("subscribeevent",),
}
_TYPES: tuple[DataType, ...] = get_args(DataType)

_MAX_AFFORDANCES = 300
_MAX_FORMS = 100
"""Most forms: servers list dozens, one per address, protocol and content type; further ones are ignored."""

_MAX_MEMBERS = 20
_SCALARS = frozenset({"boolean", "integer", "number", "string"})
_EXTENSION = "homebot:"
_METHODS = ("htv:methodName", "cov:method", "cov:methodName", "coap:method", "coap:methodName")
"""The terms for methods in the bindings of HTTP and CoAP, and in older drafts of the latter."""

_UNDEFINED_VARIABLES = re.compile(r"\{[?&#][^{}]*\}")
"""Expressions of a URI template (RFC 6570, section 3.2.1) that disappear without values for their variables."""


def read_thing(description: object, source: str = "") -> Thing:
    """Return the thing described by a Thing Description, given as parsed JSON.

    Args:
        source: The address from which it was read, to resolve relative addresses.

    Raises:
        WireError: It breaks a rule of TD 1.1, or has more than 300 affordances; the message names field and value.
    """
    fields = Fields(description, "")
    value = fields.plain("@context")
    named = value if isinstance(value, list) else [value]
    if not any(isinstance(context, str) and context in _CONTEXTS for context in named):
        raise fields.problem("@context", f"must contain {CONTEXT}, the context of Thing Descriptions")
    definitions = fields.inner("securityDefinitions")
    schemes = {name: definitions.inner(name).text("scheme", required=True) for name in definitions.names()}
    required = fields.texts("security")
    if not required:
        raise fields.problem("security", "is missing; give the name of a security definition")
    if unknown := [name for name in required if name not in schemes]:
        raise fields.problem("security", f"{unknown[0][:60]!a} is not in securityDefinitions")
    try:
        base = resolve_uri(source, fields.text("base"))
    except ValueError:
        raise fields.problem("base", f"{fields.text('base')[:60]!a} is not an address") from None
    affordances = tuple(
        affordance
        for group, kind in _KINDS.items()
        for affordance in _affordances(fields.inner(group), kind, base, required)
    )
    if len(affordances) > _MAX_AFFORDANCES:
        raise fields.problem("", f"{len(affordances)} affordances are too many; the limit is {_MAX_AFFORDANCES}")
    facts = fields.inner("homebot:facts")
    return Thing(
        id=fields.text("id"),
        title=fields.text("title", required=True),
        types=_bare(fields.texts("@type")),
        description=fields.text("description"),
        affordances=affordances,
        facts={name: facts.text(name) for name in facts.names() if isinstance(facts.plain(name), str)},
        area=fields.text("homebot:area"),
        identifiers=fields.texts("homebot:identifiers"),
        security=schemes,
    )


def _affordances(group: Fields, kind: AffordanceKind, base: str, security: tuple[str, ...]) -> Iterator[Affordance]:
    for name in group.names():
        fields = group.inner(name)
        read_only, write_only = fields.flag("readOnly"), fields.flag("writeOnly")
        if read_only and write_only:
            raise fields.problem("writeOnly", "readOnly and writeOnly exclude each other")
        schema = fields if kind == "property" else fields.inner("input" if kind == "action" else "data")
        unfit = {"writeproperty"} if read_only else {"readproperty", "observeproperty"} if write_only else set()
        forms = tuple(_forms(fields, kind, base, security, unfit))
        yield Affordance(
            name=name,
            kind=kind,
            title=fields.text("title"),
            types=_bare(fields.texts("@type")),
            schema=_schema(schema),
            read_only=read_only,
            write_only=write_only,
            forms=forms,
            extension={
                name.removeprefix(_EXTENSION): fields.text(name)
                for name in fields.names()
                if name.startswith(_EXTENSION) and isinstance(fields.plain(name), str)
            },
        )


def _forms(
    fields: Fields, kind: AffordanceKind, base: str, security: tuple[str, ...], unfit: Collection[str]
) -> Iterator[Form]:
    """Parse the forms of an affordance, without *unfit* operations unless there are no others."""
    if not fields.listed("forms"):
        raise fields.problem("forms", "is empty; give at least one form")
    for number, described in enumerate(fields.listed("forms")[:_MAX_FORMS]):
        form = Fields(described, fields.where(f"forms[{number}]"))
        ops = form.texts("op") or _DEFAULT_OPS[kind]
        for op in ops:
            if op not in _OPS[kind]:
                raise form.problem("op", f"{op[:60]!a} is none of {', '.join(_OPS[kind])}")
        yield _form(form, tuple(op for op in ops if op not in unfit) or ops, base, security)


def _form(form: Fields, ops: tuple[str, ...], base: str, security: tuple[str, ...]) -> Form:
    if "href" not in form:
        raise form.problem("href", "is missing; give an address")
    href = form.text("href")
    try:
        scheme, path = urlsplit(href).scheme, urlsplit(href).path
        scheme = scheme or urlsplit(base).scheme
        address = resolve_uri(base, _UNDEFINED_VARIABLES.sub("", href))
    except ValueError:
        raise form.problem("href", f"{href[:60]!a} is not an address") from None
    packet = form.text("mqv:controlPacket").rpartition(":")[2]
    # in many TDs the topic is in the path of the address; mqv: terms are preferred
    in_path = unquote(path).removeprefix("/") if scheme in {"mqtt", "mqtts"} else ""
    filters, named = form.texts("mqv:filter"), form.text("mqv:topic") or in_path
    topic = named if WRITE_OPS & set(ops) and packet != "subscribe" else ""
    observed = (filters[0] if filters else named) if OBSERVE_OPS & set(ops) and packet != "publish" else ""
    retain = form.plain("mqv:retain")  # some write a text
    return Form(
        ops=ops,
        scheme=scheme.lower(),
        href=address,
        subprotocol=form.text("subprotocol"),
        method=next((method for name in _METHODS if (method := form.text(name))), "").upper(),
        security=form.texts("security") or security,
        topic=topic,
        filter=observed,
        qos=_qos(form),
        retain=retain == "true" if retain in ("true", "false") else form.flag("mqv:retain"),
        content_type=form.text("contentType") or "application/json",
        response_type=form.inner("response").text("contentType"),
    )


def _qos(form: Fields) -> int:
    """Parse ``"1"``, 1, or ``quality:1`` of older drafts."""
    value = form.plain("mqv:qos")
    if value is None:
        return 0
    text = value.rpartition(":")[2] if isinstance(value, str) else value
    for qos in (0, 1, 2):
        if not isinstance(text, bool) and text in (qos, str(qos)):  # a tuple: it need not be hashable
            return qos
    raise form.problem("mqv:qos", "0, 1 or 2 is expected")


def _schema(fields: Fields, *, is_member: bool = False) -> DataSchema:
    kind = _type(fields)
    if not kind and (chosen := _alternative(fields)) is not None:
        return chosen
    members = fields.inner("properties") if kind == "object" and not is_member else None
    if members is not None and len(names := members.names()) == 1:  # an object with one member stands for that
        return replace(_schema(members.inner(names[0]), is_member=True), member=names[0])
    several = () if members is None else tuple(_members(fields, members))
    enum = fields.listed("enum")
    if "enum" in fields and not enum:
        raise fields.problem("enum", "at least one value is expected")
    values = tuple(value for value in enum if isinstance(value, (str, float, int, bool)))
    minimum, maximum = fields.number("minimum"), fields.number("maximum")
    if minimum is not None and maximum is not None and minimum > maximum:
        raise fields.problem("minimum", f"{minimum:g} is above the maximum {maximum:g}")
    return DataSchema(
        type=kind, unit=fields.text("unit"), minimum=minimum, maximum=maximum, enum=values, members=several
    )


def _type(fields: Fields) -> DataType:
    kind = fields.text("type")
    for known in _TYPES:
        if known == kind:
            return known
    raise fields.problem("type", f"{kind[:60]!a} is none of {', '.join(filter(None, _TYPES))}")


def _alternative(fields: Fields) -> DataSchema | None:
    """Return the number among the alternatives of a schema, or the only non-null one; otherwise None."""
    name = "oneOf" if "oneOf" in fields else "anyOf"
    given = [schema for schema in fields.listed(name) if isinstance(schema, dict) and schema.get("type") != "null"]
    schemas = [_schema(Fields(schema, fields.where(name)), is_member=True) for schema in given]
    numbers = [schema for schema in schemas if schema.type in ("integer", "number")] or schemas
    if len(numbers) != 1:
        return None
    number = numbers[0]
    others = [schema for schema in schemas if schema is not number]
    words = tuple(text for schema in others for text in schema.enum if isinstance(text, str))
    return replace(number, unit=number.unit or fields.text("unit"), words=words)


def _members(fields: Fields, members: Fields) -> Iterator[tuple[str, DataSchema]]:
    required = fields.texts("required") or members.names()
    for name in members.names()[:_MAX_MEMBERS]:
        schema = _schema(members.inner(name), is_member=True)
        if name in required and schema.type in _SCALARS:
            yield name, replace(schema, member=name)


def _bare(types: tuple[str, ...]) -> tuple[str, ...]:
    """Return *types* without prefix or namespace: ``iot:BinarySwitch`` is ``BinarySwitch``."""
    return tuple(kind.rpartition("#")[2].rpartition("/")[2].rpartition(":")[2] for kind in types)
