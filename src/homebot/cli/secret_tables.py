"""Tables of the configuration that a command adds, each with a secret in a file of its own."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from homebot.cli.commands.run import with_environment
from homebot.config import parse_config
from homebot.errors import UsageError
from homebot.runtime.plan import Plan, make_plan
from homebot.support.toml_file import parse_toml


def text_of(config: Path) -> str:
    """Return the text of the file *config*; empty if there is none.

    Raises:
        UsageError: It cannot be read.
    """
    try:
        return config.read_text(encoding="utf-8-sig") if config.exists() else ""
    except (OSError, UnicodeDecodeError) as exc:
        raise UsageError(f"{config} cannot be read: {exc}") from exc


def add_secret_table(
    config: Path, table: str, secret_file: Path, secret: str, check: Callable[[Plan], None], *, creates: bool
) -> None:
    """Write *secret* to a new file that only its owner can read, and append the *table* that names it to *config*.

    Args:
        check: Raises UsageError for what is wrong in the plan of *config* with the table.
        creates: Whether *config* is made if there is none; else the table is only checked.

    Raises:
        UsageError: The table is there already, or wrong, or a file cannot be written; then nothing was.
    """
    before, head = text_of(config), table.partition("\n")[0]
    if head in before:
        raise UsageError(f"{config} has a table {head}; choose another name, or remove it first")
    try:
        secret_file.touch(0o600, exist_ok=False)
    except OSError as exc:
        hint = "; choose another name" if isinstance(exc, FileExistsError) else ""
        raise UsageError(f"{secret_file} cannot be written: {exc.strerror}{hint}") from exc
    try:
        secret_file.write_text(f"{secret}\n", encoding="ascii")
        tables = parse_toml(f"{before}\n{table}", str(config))
        check(make_plan(with_environment(parse_config(tables, str(config), config.parent))))
        if creates or config.exists():
            with config.open("a", encoding="utf-8") as file:
                file.write(f"\n{table}" if before else table)
    except (UsageError, OSError) as exc:
        secret_file.unlink()
        raise UsageError(f"{exc}; nothing was written") from exc
