"""Thing Descriptions in: checked against the shape that TD 1.1 demands. Pure.

What the description leaves out takes the default of the specification, and what is unknown is passed over. Descriptions
of version 1.0 are read as well.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Final, get_args
from urllib.parse import unquote, urlsplit

from homebot.errors import WireError
from homebot.wot.thing import Affordance, AffordanceKind, DataSchema, DataType, Form, Thing

__all__ = ["CONTEXT", "MAX_TEXT", "Fields", "read_thing"]


MAX_TEXT: Final = 1000
"""Characters of a text that somebody wrote for people; longer ones are cut."""

_MAX_LISTED = 300
_MAX_NAME = 200
_MAX_SHOWN = 60
_MOST = 10**20


class Fields:
    """One JSON object, whose fields are asked for by name and type; a missing one is empty.

    Args:
        value: What should be an object.
        path: Where it stands, for errors: ``properties.on.forms[0]``.

    Raises:
        WireError: It is none.
    """

    def __init__(self, value: object, path: str) -> None:
        self._path = path
        if not isinstance(value, Mapping):
            raise self._wrong("", "an object", value)
        self._value: Mapping[object, object] = value

    def __contains__(self, name: str) -> bool:
        return name in self._value

    def problem(self, name: str, problem: str) -> WireError:
        """Return the error that something is wrong with a field."""
        return WireError(f"{self._where(name)}: {problem}")

    def text(self, name: str, *, required: bool = False) -> str:
        """Return a text, without control characters.

        Raises:
            WireError: It is none, or is missing or empty where it is *required*.
        """
        value = self._value.get(name)
        if value is None and not required:
            return ""
        if not isinstance(value, str) or (required and not value.strip()):
            raise self._wrong(name, "a text", value)
        return "".join(one if one.isprintable() else " " for one in value[:MAX_TEXT]).strip()

    def flag(self, name: str) -> bool:
        """Return a boolean; False where it is missing."""
        value = self._value.get(name, False)
        if not isinstance(value, bool):
            raise self._wrong(name, "true or false", value)
        return value

    def number(self, name: str) -> float | None:
        """Return a number; None where it is missing."""
        value = self._value.get(name)
        if value is None:
            return None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise self._wrong(name, "a number", value)
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self._wrong(name, "a finite number", value)
        return number

    def texts(self, name: str) -> tuple[str, ...]:
        """Return a text or a list of texts, as a tuple."""
        value = self._value.get(name)
        if value is None:
            return ()
        listed = value if isinstance(value, list) else [value]
        if not all(isinstance(one, str) for one in listed):
            raise self._wrong(name, "a text or a list of texts", value)
        self._check_length(name, len(listed))
        return tuple(str(one)[:MAX_TEXT] for one in listed)

    def plain(self, name: str) -> object:
        """Return a field as it is; None where it is missing."""
        return self._value.get(name)

    def listed(self, name: str) -> tuple[object, ...]:
        """Return the elements of a list."""
        value = self._value.get(name)
        if value is None:
            return ()
        if not isinstance(value, list):
            raise self._wrong(name, "a list", value)
        self._check_length(name, len(value))
        return tuple(value)

    def inner(self, name: str) -> Fields:
        """Return the object in a field; an empty one where it is missing."""
        return Fields(self._value.get(name, {}), self._where(name))

    def names(self) -> tuple[str, ...]:
        """Return the names of all fields.

        Raises:
            WireError: They are more than 300, or one is longer than 200 characters.
        """
        self._check_length("", len(self._value))
        for name in self._value:
            if not isinstance(name, str) or len(name) > _MAX_NAME:
                raise self.problem(str(name), f"a name of at most {_MAX_NAME} characters is expected")
        return tuple(str(name) for name in self._value)

    def at(self, name: str) -> str:
        """Return where a field stands."""
        return self._where(name)

    def _check_length(self, name: str, length: int) -> None:
        if length > _MAX_LISTED:
            raise self.problem(name, f"{length} is too many; the limit is {_MAX_LISTED}")

    def _where(self, name: str) -> str:
        text = name if len(name) <= _MAX_SHOWN else f"{name[:_MAX_SHOWN]}…"
        text = text if text.isprintable() else ascii(text)
        return f"{self._path}.{text}" if self._path and name else text or self._path or "the description"

    def _wrong(self, name: str, expected: str, value: object) -> WireError:
        if value is None:
            return self.problem(name, f"is missing; expected {expected}")
        return self.problem(name, f"expected {expected}, got {_shown(value)}")


def _shown(value: object) -> str:
    match value:
        case dict():
            return "an object"
        case list():
            return "a list"
        case bool():
            return "true" if value else "false"
        case int() if abs(value) >= _MOST:
            return "a finite number"
        case _:
            return ascii(value[:_MAX_SHOWN] if isinstance(value, str) else value)


CONTEXT: Final = "https://www.w3.org/2022/wot/td/v1.1"
_CONTEXTS = frozenset({CONTEXT, "https://www.w3.org/2019/wot/td/v1", "http://www.w3.org/ns/td"})

_KINDS: Mapping[str, AffordanceKind] = {"properties": "property", "actions": "action", "events": "event"}
_OPS: Mapping[AffordanceKind, tuple[str, ...]] = {
    "property": ("readproperty", "writeproperty", "observeproperty", "unobserveproperty"),
    "action": ("invokeaction", "queryaction", "cancelaction"),
    "event": ("subscribeevent", "unsubscribeevent"),
}
_OBSERVE_OPS = frozenset({"readproperty", "observeproperty", "subscribeevent"})
_WRITE_OPS = frozenset({"writeproperty", "invokeaction"})
_TYPES: tuple[DataType, ...] = get_args(DataType)

_MAX_AFFORDANCES = 300
_MAX_FORMS = 20
_EXTENSION = "homebot:"


def read_thing(description: object) -> Thing:
    """Return the thing that a Thing Description, as parsed JSON, describes.

    Raises:
        WireError: It breaks a rule of TD 1.1, or has more than 300 affordances; names the field and its value.
    """
    fields = Fields(description, "")
    _check_context(fields)
    _check_security(fields)
    base = fields.text("base")
    affordances = tuple(
        affordance for group, kind in _KINDS.items() for affordance in _affordances(fields.inner(group), kind, base)
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
    )


def _check_context(fields: Fields) -> None:
    value = fields.plain("@context")
    named = value if isinstance(value, list) else [value]
    if not any(isinstance(one, str) and one in _CONTEXTS for one in named):
        raise fields.problem("@context", f"must contain {CONTEXT}, the context of Thing Descriptions")


def _check_security(fields: Fields) -> None:
    definitions = fields.inner("securityDefinitions")
    names = definitions.names()
    for name in names:
        definitions.inner(name).text("scheme", required=True)
    required = fields.texts("security")
    if not required:
        raise fields.problem("security", "is missing; give the name of a security definition")
    for name in required:
        if name not in names:
            raise fields.problem("security", f"{name[:60]!a} is not in securityDefinitions")


def _affordances(group: Fields, kind: AffordanceKind, base: str) -> Iterator[Affordance]:
    for name in group.names():
        fields = group.inner(name)
        read_only, write_only = fields.flag("readOnly"), fields.flag("writeOnly")
        if read_only and write_only:
            raise fields.problem("writeOnly", "readOnly and writeOnly exclude each other")
        schema = fields if kind == "property" else fields.inner("input" if kind == "action" else "data")
        forms = tuple(_forms(fields, kind, base, read_only=read_only, write_only=write_only))
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


def _forms(fields: Fields, kind: AffordanceKind, base: str, *, read_only: bool, write_only: bool) -> Iterator[Form]:
    forms = fields.listed("forms")
    if not 0 < len(forms) <= _MAX_FORMS:
        raise fields.problem("forms", f"1 to {_MAX_FORMS} forms are expected, got {len(forms)}")
    default = {"property": ("readproperty", "writeproperty"), "action": ("invokeaction",), "event": ("subscribeevent",)}
    for number, one in enumerate(forms):
        form = Fields(one, fields.at(f"forms[{number}]"))
        ops = form.texts("op") or default[kind]
        for op in ops:
            if op not in _OPS[kind]:
                raise form.problem("op", f"{op[:60]!a} is none of {', '.join(_OPS[kind])}")
        unfit = {"writeproperty"} if read_only else {"readproperty", "observeproperty"} if write_only else set()
        yield _form(form, tuple(op for op in ops if op not in unfit) or ops, base)


def _form(form: Fields, ops: tuple[str, ...], base: str) -> Form:
    """Parse a form; in many TDs the topic stands in the path of the address; what ``mqv:`` has counts more."""
    if "href" not in form:
        raise form.problem("href", "is missing; give an address")
    href = form.text("href")
    try:
        scheme, path = urlsplit(href).scheme, urlsplit(href).path
        scheme = scheme or urlsplit(base).scheme
    except ValueError:
        raise form.problem("href", f"{href[:60]!a} is not an address") from None
    is_mqtt = scheme in {"mqtt", "mqtts"}
    in_path = unquote(path).removeprefix("/") if is_mqtt else ""
    packet = form.text("mqv:controlPacket").rpartition(":")[2]
    filters, named = form.texts("mqv:filter"), form.text("mqv:topic") or in_path
    topic = named if _WRITE_OPS & set(ops) and packet != "subscribe" else ""
    observed = filters[0] if filters else named
    observed = observed if _OBSERVE_OPS & set(ops) and packet != "publish" else ""
    return Form(
        ops=ops,
        scheme=scheme.lower(),
        topic=topic,
        filter=observed,
        qos=_qos(form),
        retain=_retain(form),
        content_type=form.text("contentType") or "application/json",
    )


def _retain(form: Fields) -> bool:
    """Parse a boolean, or its text, as some write it."""
    value = form.plain("mqv:retain")
    return value == "true" if isinstance(value, str) and value in {"true", "false"} else form.flag("mqv:retain")


def _qos(form: Fields) -> int:
    """Parse ``"1"``, 1, or ``quality:1`` as older drafts have it."""
    value = form.plain("mqv:qos")
    if value is None:
        return 0
    text = value.rpartition(":")[2] if isinstance(value, str) else value
    for qos in (0, 1, 2):
        if not isinstance(text, bool) and text in (qos, str(qos)):  # a tuple: it need not be hashable
            return qos
    raise form.problem("mqv:qos", "0, 1 or 2 is expected")


def _schema(fields: Fields) -> DataSchema:
    kind = fields.text("type")
    found = next((one for one in _TYPES if one == kind), None)
    if found is None:
        raise fields.problem("type", f"{kind[:60]!a} is none of {', '.join(one for one in _TYPES if one)}")
    enum = fields.listed("enum")
    if "enum" in fields and not enum:
        raise fields.problem("enum", "at least one value is expected")
    minimum, maximum = fields.number("minimum"), fields.number("maximum")
    if minimum is not None and maximum is not None and minimum > maximum:
        raise fields.problem("minimum", f"{minimum:g} is above the maximum {maximum:g}")
    return DataSchema(
        type=found,
        unit=fields.text("unit"),
        minimum=minimum,
        maximum=maximum,
        enum=tuple(one for one in enum if isinstance(one, (str, float, int, bool))),
    )


def _bare(types: tuple[str, ...]) -> tuple[str, ...]:
    """Return *types* without prefix or namespace: ``iot:BinarySwitch`` is ``BinarySwitch``."""
    return tuple(one.rpartition("#")[2].rpartition("/")[2].rpartition(":")[2] for one in types)
