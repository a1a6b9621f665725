"""The language of the owner, for the command line."""

from contextlib import suppress

from homebot.cli.arguments import DEFAULT_CONFIG
from homebot.config_lines import language_in


def owner_language() -> str:
    """Return the language in ``homebot.toml`` of the working directory; empty if it says none."""
    with suppress(OSError, ValueError):
        return language_in(DEFAULT_CONFIG.read_text("utf-8-sig"))
    return ""


def said(message: str) -> str:
    """Return *message* as the owner, or the text that it is about, says it; as it is if the language is unknown."""
    if not (language := owner_language()):
        return message
    from homebot.words.mistakes import mistake_in  # noqa: PLC0415 - loads pydantic

    return mistake_in(language, message)
