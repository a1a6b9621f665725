"""Settings of gateways and apps as parameters of their nodes.

They are read-only, because tables of the configuration are read at the start.
"""

import inspect
import json
import re
from contextlib import suppress
from typing import Final

from pydantic import BaseModel, SecretStr
from pydantic_core import to_json

from homebot.errors import ParameterError
from homebot.graph import Node, ParameterDescriptor

_ATTRIBUTE: Final = re.compile(r"^ {4}(\w+): (.+(?:\n {8}.+)*)", re.MULTILINE)
_LOGIN: Final = re.compile(r'(?<=://)[^/\s"]*@')


def declare_settings(node: Node, settings: BaseModel, prefix: str = "") -> None:
    """Declare the values in *settings* as parameters of *node*; values in tables have dotted names.

    Unset values, secrets, logins in addresses, and lists of tables are left out.
    """
    docs = (inspect.getdoc(base) or "" for base in reversed(type(settings).__mro__) if issubclass(base, BaseModel))
    descriptions = dict(_ATTRIBUTE.findall("\n".join(docs)))
    for key, value in settings:
        field = type(settings).model_fields.get(key)
        if isinstance(value, SecretStr) or (field is not None and not field.repr):
            continue
        name = f"{prefix}{key}"
        if isinstance(value, BaseModel):
            declare_settings(node, value, f"{name}.")
            continue
        plain = json.loads(_LOGIN.sub("", to_json(value).decode()))
        text = " ".join(descriptions.get(key, "").split()).replace("``", "")
        with suppress(ParameterError):  # not a parameter value, or the node has a parameter of that name
            node.declare_parameter(name, plain, ParameterDescriptor(text, read_only=True))
