"""New files: only their owner reads them, and none is replaced."""

from pathlib import Path

import pytest

from homebot.errors import UsageError
from homebot.support.new_file import create_file


def test_only_the_owner_of_a_new_file_reads_it(tmp_path: Path) -> None:
    with create_file(tmp_path / "new") as file:
        file.write(b"text")
    assert (tmp_path / "new").read_bytes() == b"text"
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o600


def test_no_file_is_replaced_not_even_through_a_link(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(tmp_path / "target")
    with pytest.raises(UsageError, match="link exists already; delete it, or choose another name"):
        create_file(tmp_path / "link")
    with pytest.raises(UsageError, match="new cannot be written: No such file or directory"):
        create_file(tmp_path / "missing" / "new")
