"""Settings of gateways and apps as parameters of their nodes.

They are read-only, because tables of the configuration are read at the start.
"""

import inspect
import json
import re
from contextlib import suppress
from typing import Final

from pydantic import BaseModel
from pydantic_core import to_json

from homebot.errors import ParameterError
from homebot.graph import Node, ParameterDescriptor
from homebot.support.key_roles import KeyRole, role_of, without_login

_ATTRIBUTE: Final = re.compile(r"^ {4}(\w+): (.+(?:\n {8}.+)*)", re.MULTILINE)


def declare_settings(node: Node, settings: BaseModel, prefix: str = "") -> None:
    """Declare the values in *settings* as parameters of *node*; values in tables have dotted names.

    Unset values, secrets, logins in addresses, and lists of tables are left out.
    """
    docs = (inspect.getdoc(base) or "" for base in reversed(type(settings).__mro__) if issubclass(base, BaseModel))
    descriptions = dict(_ATTRIBUTE.findall("\n".join(docs)))
    for key, value in settings:
        field = type(settings).model_fields.get(key)
        if field is not None and (not field.repr or role_of(key, field) is KeyRole.SECRET):
            continue
        name = f"{prefix}{key}"
        if isinstance(value, BaseModel):
            declare_settings(node, value, f"{name}.")
            continue
        plain = json.loads(without_login(to_json(value).decode(), ""))
        text = " ".join(descriptions.get(key, "").split()).replace("``", "")
        with suppress(ParameterError):  # not a parameter value, or the node has a parameter of that name
            node.declare_parameter(name, plain, ParameterDescriptor(text, read_only=True))
