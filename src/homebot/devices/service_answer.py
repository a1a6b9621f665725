"""Base of the answers of services that may fail for a reason that is told in words."""

from homebot.messages.message import Message

__all__ = ["ServiceAnswer"]


class ServiceAnswer(Message):
    """The result of a request.

    Attributes:
        success: Whether the request was carried out.
        message: The reason if not, as text.
    """

    success: bool
    message: str = ""
