"""Messages of a package of ROS that are made of their text when they are first imported."""

from collections.abc import Callable
from typing import Any

from homebot.errors import UnknownTypeError

__all__ = ["text_messages"]


def text_messages(package: str) -> Callable[[str], Any]:
    """Return the ``__getattr__`` of the module ``homebot.messages.PACKAGE``, by the names of messages in it.

    To a type checker, which cannot read the text, each is any class.
    """

    def find(name: str) -> Any:
        from homebot.messages.interfaces import find_message  # noqa: PLC0415 - most packages are never asked for

        try:
            return find_message(f"{package}/msg/{name}")
        except UnknownTypeError as exc:
            raise AttributeError(f"homebot.messages.{package}: {exc}") from None

    return find
