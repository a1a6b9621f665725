"""Messages of ROS packages that are built from their definitions on first import."""

from collections.abc import Callable
from functools import partial
from typing import Any

from homebot.errors import UnknownTypeError


def text_messages(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of the module ``homebot.messages.PACKAGE``, which builds messages by name.

    For a type checker, which cannot read the definitions, each is any class.
    """
    return partial(_find, package)


def _find(package: str, name: str) -> Any:
    from homebot.messages.interfaces import find_message  # noqa: PLC0415 - most packages are never asked for

    try:
        return find_message(f"{package}/msg/{name}")
    except UnknownTypeError as exc:
        raise AttributeError(f"homebot.messages.{package}: {exc}") from None
