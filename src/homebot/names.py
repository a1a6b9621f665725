"""Names on the graph: their rules, their expansion, and an escape that turns any text into a name.

The rules are those of ROS 2 (rmw ``validate_node_name``, ``validate_namespace``, ``validate_full_topic_name``; rcl
``expand_topic_name``): tokens of ``[A-Za-z0-9_]`` that do not start with a digit, joined by ``/``.
"""

import re
from functools import lru_cache

from homebot.errors import InvalidNameError

MAX_NODE_NAME = 255
MAX_NAMESPACE = 245
MAX_FULL_NAME = 247  # 255 less the 8 characters that DDS prefixes take

_BAD_CHARACTER = re.compile(r"[^A-Za-z0-9_]")
_BAD_PATH_CHARACTER = re.compile(r"[^A-Za-z0-9_/]")
_TOKEN_STARTS_WITH_DIGIT = re.compile(r"(?:^|/)([0-9])")
_SUBSTITUTION = re.compile(r"\{([^{}]*)\}")


def validate_node_name(name: str) -> str:
    """Return *name* if it is a legal node name.

    Raises:
        InvalidNameError: Empty, a character outside ``[A-Za-z0-9_]``, a leading digit, or over 255 characters.
    """
    kind = "node name"
    if not name:
        raise InvalidNameError(kind, name, "is empty")
    if bad := _BAD_CHARACTER.search(name):
        raise InvalidNameError(kind, name, "has a character that is not allowed in names", bad.start())
    if name[0].isdigit():
        raise InvalidNameError(kind, name, "starts with a digit", 0)
    return _check_length(kind, name, MAX_NODE_NAME)


def validate_namespace(namespace: str) -> str:
    """Return *namespace* if it is legal: ``/``, or absolute without a trailing slash.

    Raises:
        InvalidNameError: It is not absolute, ends in a slash, or a token of it is illegal.
    """
    if namespace == "/":
        return namespace
    return _check_length("namespace", _validate_path("namespace", namespace), MAX_NAMESPACE)


@lru_cache(maxsize=4096)
def validate_full_name(name: str, kind: str = "topic name") -> str:
    """Return *name* if it is a legal full (absolute) topic or service name.

    Raises:
        InvalidNameError: It is not absolute, ends in a slash, contains ``//`` or a bad character, a token starts with
            a digit, or it is over 247 characters.
    """
    return _check_length(kind, _validate_path(kind, name), MAX_FULL_NAME)


def absolute_name(name: str) -> str:
    """Return *name* with a leading slash, which people and some programs omit."""
    return name if name.startswith("/") else f"/{name}"


def full_node_name(node: str, namespace: str = "/") -> str:
    """Return the full name of *node* in *namespace*; both are checked. A relative namespace starts at the root."""
    namespace = absolute_name(namespace)
    validate_namespace(namespace)
    return f"{namespace.rstrip('/')}/{validate_node_name(node)}"


def expand_name(name: str, node: str, namespace: str, kind: str = "topic name") -> str:
    """Return the full name to which *name* expands for *node* in *namespace*.

    In this order: ``~`` becomes the node's full name; ``{node}``, ``{ns}`` and ``{namespace}`` are replaced; a name
    that is still relative goes below the namespace.

    Raises:
        InvalidNameError: The name, or its expansion, is illegal.
    """
    if not name:
        raise InvalidNameError(kind, name, "is empty")
    node_path = f"{namespace.rstrip('/')}/{node}"
    if "~" in name:
        if (misplaced := name.find("~", 1)) >= 0:
            raise InvalidNameError(kind, name, "has a tilde that is not at its start", misplaced)
        if len(name) > 1 and name[1] != "/":
            raise InvalidNameError(kind, name, "has a tilde that is not followed by a slash", 1)
        name = node_path + name[1:]
    if "{" in name or "}" in name:
        name = _substitute(name, node, namespace, kind)
    if not name.startswith("/"):
        name = f"{namespace.rstrip('/')}/{name}"
    return validate_full_name(name, kind)


def is_hidden(name: str) -> bool:
    """Return whether tools hide *name* by default: one of its tokens starts with an underscore."""
    return "/_" in name or name.startswith("_")


def escape_token(text: str) -> str:
    """Return a legal, visible token for any non-empty *text*; :func:`unescape_token` restores the text.

    - Each UTF-8 byte outside ``[A-Za-z0-9_]`` becomes ``_xHH`` (two lower-case hexadecimal digits).
    - An underscore that would read as the start of such an escape becomes ``_x5f``.
    - A result that starts with a digit, an underscore or ``x_`` gets ``x_`` in front: tokens may not start with a
      digit, and a leading underscore would hide the name.

    ``roomlights405`` stays, ``Küche 1`` is ``K_xc3_xbcche_x201``, ``0x00158d`` is ``x_0x00158d``.

    Raises:
        InvalidNameError: *text* is empty or contains a lone surrogate.
    """
    if not text:
        raise InvalidNameError("name", text, "is empty")
    try:
        text.encode()
    except UnicodeEncodeError as exc:
        raise InvalidNameError("name", text, "is not valid Unicode", exc.start) from exc
    text = re.sub(r"_(?=x[0-9a-f]{2})", "_x5f", text)
    token = _BAD_CHARACTER.sub(lambda found: "".join(f"_x{byte:02x}" for byte in found[0].encode()), text)
    return f"x_{token}" if re.match(r"[0-9_]|x_", token) else token


def unescape_token(token: str) -> str:
    """Return the text from which :func:`escape_token` built *token*.

    Raises:
        InvalidNameError: The escapes do not spell UTF-8.
    """
    raw = token.removeprefix("x_").encode()
    try:
        return re.sub(rb"_x([0-9a-f]{2})", lambda found: bytes([int(found[1], 16)]), raw).decode()
    except UnicodeDecodeError as exc:
        raise InvalidNameError("escaped name", token, "does not decode to UTF-8") from exc


def _validate_path(kind: str, path: str) -> str:
    if not path:
        raise InvalidNameError(kind, path, "is empty")
    if bad := _BAD_PATH_CHARACTER.search(path):
        raise InvalidNameError(kind, path, "has a character that is not allowed in names", bad.start())
    if not path.startswith("/"):
        raise InvalidNameError(kind, path, "is not absolute: it must start with /")
    if path.endswith("/"):
        raise InvalidNameError(kind, path, "ends with a slash", len(path) - 1)
    if (double := path.find("//")) >= 0:
        raise InvalidNameError(kind, path, "has an empty token", double + 1)
    if digit := _TOKEN_STARTS_WITH_DIGIT.search(path):
        raise InvalidNameError(kind, path, "has a token that starts with a digit", digit.start(1))
    return path


def _substitute(name: str, node: str, namespace: str, kind: str) -> str:
    known = {"node": node, "ns": namespace, "namespace": namespace}

    def value(found: re.Match[str]) -> str:
        if found[1] not in known:
            raise InvalidNameError(kind, name, f"has an unknown substitution {found[0]}", found.start())
        text = known[found[1]]
        return "" if text == "/" and found.string.startswith("/", found.end()) else text  # no second slash at the root

    blanked = _SUBSTITUTION.sub(lambda found: " " * len(found[0]), name)
    if (brace := re.search(r"[{}]", blanked)) is not None:
        raise InvalidNameError(kind, name, "has an unmatched brace", brace.start())
    return _SUBSTITUTION.sub(value, name)


def _check_length(kind: str, name: str, limit: int) -> str:
    if len(name) > limit:
        raise InvalidNameError(kind, name, f"is {len(name)} characters long, over the limit of {limit}")
    return name


def snake_case(class_name: str) -> str:
    """Return the name of an app by its class name: ``my_app`` for ``MyApp``."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", class_name).lower()
