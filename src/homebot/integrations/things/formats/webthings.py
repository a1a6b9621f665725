"""Descriptions of the Web Thing API, which is older than the forms of Thing Descriptions, as those. Pure.

Many self-made devices run a library of this API. That for Arduino lists its things, also a single one, by ids that are
no URIs: each house has a ``led``. Their properties are read and written as an object with one member,
``{"on": true}``, at the address of a link. Actions and events are left out: they have protocols of their own.

Source: Web Thing API, https://webthings.io/api, sections 3 and 4, as the libraries ``webthing`` for Python and Arduino
serve it.
"""

from collections.abc import Mapping
from typing import Final

from homebot.conventions.payload import as_fields
from homebot.integrations.things.formats.thing import NO_SECURITY

_CONTEXTS: Final = frozenset({"https://iot.mozilla.org/schemas", "https://webthings.io/schemas"})
_SCHEMA: Final = ("type", "unit", "minimum", "maximum", "enum")
_KEPT: Final = ("@type", "title", "description", "readOnly")


def with_forms(description: object, context: str) -> object:
    """Return the description of a Web Thing as a Thing Description of this *context*; another description as it is."""
    only = description[0] if isinstance(description, list) and len(description) == 1 else description
    fields = as_fields(only)
    named = fields.get("@context")
    if not (isinstance(named, str) and named.rstrip("/") in _CONTEXTS):
        return description
    properties = as_fields(fields.get("properties"))
    affordances = {name: made for name, fields in properties.items() if (made := _property(name, as_fields(fields)))}
    everything = _link(fields, "properties")
    return {
        **NO_SECURITY,
        **fields,
        **({} if isinstance(fields.get("securityDefinitions"), dict) else NO_SECURITY),  # one version has it as text
        "id": fields.get("id") if ":" in str(fields.get("id")) else None,
        "@context": context,
        "title": fields.get("title", fields.get("name")),
        "properties": affordances,
        "actions": {},
        "events": {},
        "forms": [{"href": everything, "op": "readallproperties"}] if everything else [],
    }


def _property(name: str, described: Mapping[str, object]) -> dict[str, object]:
    href = _link(described, "property")
    if not href:
        return {}
    schema = {key: described[key] for key in _SCHEMA if described.get(key) is not None}
    kept = {key: described[key] for key in _KEPT if key in described}
    return {**kept, "type": "object", "properties": {name: schema}, "forms": [{"href": href}]}


def _link(described: Mapping[str, object], relation: str) -> str:
    """Return the address of the first link of a *relation*; the first libraries named none."""
    links = described.get("links")
    for entry in links if isinstance(links, list) else ():
        link = as_fields(entry)
        href = link.get("href")
        if isinstance(href, str) and link.get("rel", "property") == relation:
            return href
    return ""
