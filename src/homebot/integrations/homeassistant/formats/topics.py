"""Topics of states and commands, and the messages there. Pure.

Source: Home Assistant core 2025.4, ``components/mqtt/util.py``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import NamedTuple

from homebot.conventions.description import Publication, Publications
from homebot.conventions.payload import MAX_LONG_STATE_BYTES, shown
from homebot.conventions.unreadable import WholePayload, unreadable
from homebot.errors import InvalidNameError, RefusedError, WireError
from homebot.integrations.homeassistant.formats.jinja import (
    PayloadContext,
    Template,
    TemplateError,
    UndefinedValueError,
)
from homebot.integrations.homeassistant.formats.jinja.values import UNDEFINED


@lru_cache(maxsize=256)
def valid_topic(field: str, topic: str, validate: Callable[[str], object]) -> str:
    """Return *topic*, in *field*, which must be valid for *validate*, and without control characters.

    Raises:
        WireError: It is not.
    """
    try:
        validate(topic)
    except InvalidNameError as error:
        raise WireError(f"{field} {shown(topic)} {error.problem}") from None
    if _FORBIDDEN.search(topic):
        raise WireError(f"{field} {shown(topic)} has a control character")
    return topic


_FORBIDDEN = re.compile("[\x00-\x1f\x7f-\x9f\ufdd0-\ufdef\ufffe\uffff]")


@lru_cache(maxsize=4)  # the parts of a device read the same message, one after the other, each in its encoding
def _context(payload: bytes, encoding: str) -> PayloadContext | None:
    """Return the variables of a template; None if the payload is too long or no text in this encoding."""
    if len(payload) > MAX_LONG_STATE_BYTES or not encoding:
        return None
    try:
        return PayloadContext(payload.decode(encoding))
    except UnicodeDecodeError:
        return None


class ValueSource(NamedTuple):
    """One state topic, and the template that extracts one value.

    Attributes:
        template: Extracts the value; None if the whole payload is the value.
        encoding: See :attr:`DiscoveryConfig.encoding`.
        or_payload: Whether the payload is the value if the template needs a missing variable, for example because it is
            no JSON; so in Home Assistant for nearly all values.
    """

    topic: str
    template: Template | None = None
    encoding: str = "utf-8"
    variables: Mapping[str, object] | None = None
    or_payload: bool = True

    @property
    def problem(self) -> str:
        """Reason why the template is unusable; empty if it is usable."""
        return self.template.problem if self.template is not None else ""

    def text(self, payload: bytes) -> str | None:
        """Return the value as in Home Assistant; None if the message must be ignored."""
        context = _context(payload, self.encoding)
        if context is None:
            unreadable(payload if self.encoding else None, f"text in {self.encoding}")
            return None
        if self.template is None:
            return context.value
        try:
            return self.template.render_value(context, self.variables)
        except UndefinedValueError:
            is_json = context.value_json is not UNDEFINED
            if self.or_payload:
                return WholePayload(context.value) if is_json else context.value
            unreadable(None if is_json else payload, "the JSON that its template reads")
            return None
        except TemplateError as error:
            if "NoneType" not in str(error):  # null, for no value
                unreadable(payload, f"its template fails: {error}", is_template=True)
            return None

    def without_template(self) -> ValueSource:
        """Return a copy whose value is the whole payload."""
        return self._replace(template=None)

    def without_payload(self) -> ValueSource:
        """Return a copy that ignores messages without the variables of the template."""
        return self._replace(or_payload=False)


_NO_VARIABLES: Mapping[str, object] = MappingProxyType({})


class CommandTopic(NamedTuple):
    """One command topic.

    Attributes:
        template: Renders the payload; None if the value itself is the payload.
        encoding: The encoding of the payload; UTF-8 if it is empty.
    """

    topic: str
    template: Template | None = None
    qos: int = 0
    retain: bool = False
    encoding: str = "utf-8"

    def publication(self, value: object, variables: Mapping[str, object] = _NO_VARIABLES) -> Publication:
        """Return the command of *value*: the payload, or the variable ``value`` of the template, with further ones.

        Raises:
            RefusedError: The template is unusable, fails, or renders a text that cannot be encoded.
        """
        if self.template is None:
            text = str(value)
        else:
            if self.template.problem:
                raise RefusedError(f"a command on {self.topic}", f"its template {self.template.problem}")
            try:
                text = self.template.render({"value": value, **variables})
            except TemplateError as error:
                raise RefusedError(f"a command on {self.topic}", f"its template failed: {error}") from None
        try:
            payload = text.encode(self.encoding or "utf-8")
        except UnicodeEncodeError:
            raise RefusedError(f"a command on {self.topic}", f"it cannot be encoded as {self.encoding}") from None
        return Publication(self.topic, payload, self.qos, self.retain)

    def publish(self, value: object, variables: Mapping[str, object] = _NO_VARIABLES) -> Publications:
        """Return :meth:`publication` in a tuple, as writers do."""
        return (self.publication(value, variables),)

    def publication_with_code(
        self, value: object, code: str, variables: Mapping[str, object] = _NO_VARIABLES
    ) -> Publication:
        """Return :meth:`publication` with the variable *code*, which no error shows."""
        try:
            return self.publication(value, {**variables, "code": code or None})
        except RefusedError:
            if not code:
                raise
            raise RefusedError(f"a command on {self.topic}", "its template failed with this code") from None
