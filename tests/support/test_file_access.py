"""Who else may read or write a file."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

from homebot.errors import UsageError
from homebot.support.file_access import read_secret, readable_by_others, replace_file, why_not_private, why_not_trusted

NOBODYS_GROUP = 54_321
NOBODY = 65_534


def found(mode: int, *, group: int = NOBODYS_GROUP) -> os.stat_result:
    return os.stat_result((mode, 1, 1, 1, os.geteuid(), group, 0, 0, 0, 0))


@pytest.mark.parametrize("mode", [0o600, 0o400, 0o700])
def test_a_file_of_nobody_elses_is_a_secret(mode: int) -> None:
    assert why_not_private(Path("x"), found(stat.S_IFREG | mode)) == ""
    assert readable_by_others(Path("x"), found(stat.S_IFREG | mode)) == ""


@pytest.mark.parametrize("mode", [0o620, 0o602, 0o666])
def test_a_file_that_a_group_or_others_can_change_is_none(mode: int) -> None:
    assert "chmod 600 'x'" in why_not_private(Path("x"), found(stat.S_IFREG | mode))


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o644])
def test_a_file_that_a_group_or_others_can_see_is_warned_of(mode: int) -> None:
    assert why_not_private(Path("x"), found(stat.S_IFREG | mode)) == ""
    assert "chmod 600 'x'" in readable_by_others(Path("x"), found(stat.S_IFREG | mode))


def test_a_group_of_root_alone_is_nobody_else() -> None:
    """So systemd hands credentials to a service."""
    assert readable_by_others(Path("x"), found(stat.S_IFREG | 0o440, group=0)) == ""


def test_what_comes_through_a_pipe_was_written_by_who_started_homebot() -> None:
    assert why_not_private(Path("x"), found(stat.S_IFIFO | 0o666)) == ""
    assert readable_by_others(Path("x"), found(stat.S_IFIFO | 0o666)) == ""


def test_a_folder_above_in_which_each_keeps_what_is_theirs_is_fine(tmp_path: Path) -> None:
    """As /tmp, where tests live; others cannot put another file there in its place."""
    inner = tmp_path / "shared" / "mine"
    inner.mkdir(parents=True)
    file = inner / "x"
    file.touch()
    (tmp_path / "shared").chmod(0o1777)
    assert why_not_trusted(file) == ""
    (tmp_path / "shared").chmod(0o777)
    assert why_not_trusted(file) == (
        f"{tmp_path / 'shared'} can be written by others; remove that permission: chmod go-w '{tmp_path / 'shared'}'"
    )


def test_a_link_is_as_good_as_what_it_leads_to(tmp_path: Path) -> None:
    (tmp_path / "open").mkdir(mode=0o700)
    (tmp_path / "open" / "x").touch()
    (tmp_path / "link").symlink_to(tmp_path / "open" / "x")
    assert why_not_trusted(tmp_path / "link") == ""
    (tmp_path / "open").chmod(0o777)
    assert "can be written by others" in why_not_trusted(tmp_path / "link")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
def test_a_file_of_another_user_is_not_trusted(tmp_path: Path) -> None:
    file = tmp_path / "x"
    file.touch()
    os.chown(file, 54_321, -1)
    assert why_not_trusted(file).startswith(f"{file} belongs to the user 54321; run homebot as that user")
    os.chown(file, 0, -1)
    os.chown(tmp_path, 54_321, -1)
    assert why_not_trusted(file).startswith(f"{tmp_path} belongs to the user 54321")


@contextmanager
def nobody() -> Iterator[None]:
    """Act as the user nobody, if it is root that runs the tests."""
    user = os.geteuid()
    if user == 0:
        os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(user)


@pytest.fixture
def open_folder() -> Iterator[Path]:
    """Return a folder that everybody may enter, unlike those of pytest."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)
        yield folder


def test_a_secret_of_somebody_else_says_how_to_give_it_to_the_reader(open_folder: Path) -> None:
    """As in a service of the system, for which root has made a token."""
    file = open_folder / "panel.token"
    file.write_text("secret")
    file.chmod(0)
    with nobody(), pytest.raises(UsageError, match=rf"belong to the user (\w+): chown \1 '{file}'"):
        read_secret(file)


def test_a_secret_in_a_folder_of_somebody_else_is_to_be_moved(open_folder: Path) -> None:
    """As in the home of a person on Ubuntu, which no other user may enter: to own the file alone is not enough."""
    file = open_folder / "home" / "panel.token"
    file.parent.mkdir(mode=0)
    with nobody(), pytest.raises(UsageError, match=r"closed to the user \w+; move the file"):
        read_secret(file)
    file.parent.chmod(0o700)


def test_a_file_is_replaced_with_its_mode_and_behind_its_link(tmp_path: Path) -> None:
    file, link = tmp_path / "homebot.toml", tmp_path / "link"
    file.write_text("old")
    file.chmod(0o640)
    link.symlink_to(file)
    replace_file(link, b"new")
    assert (file.read_text(), stat.S_IMODE(file.stat().st_mode), link.is_symlink()) == ("new", 0o640, True)
    replace_file(tmp_path / "key", b"secret")
    assert stat.S_IMODE((tmp_path / "key").stat().st_mode) == 0o600
    assert sorted(path.name for path in tmp_path.iterdir()) == ["homebot.toml", "key", "link"]


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
@pytest.mark.parametrize(("mode", "then"), [(0o664, 0o644), (0o640, 0o600)])
def test_a_group_that_the_user_is_not_in_loses_its_rights(open_folder: Path, mode: int, then: int) -> None:
    """As in a container whose folder `chown -R 1000` gave to its user, but not to its group."""
    file = open_folder / "homebot.toml"
    file.write_text("old")
    file.chmod(mode)
    for path in (open_folder, file):
        os.chown(path, NOBODY, NOBODYS_GROUP)
    with nobody():
        replace_file(file, b"new")
    found = file.stat()
    assert (file.read_text(), stat.S_IMODE(found.st_mode), found.st_uid) == ("new", then, NOBODY)
    assert found.st_gid != NOBODYS_GROUP


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files away")
def test_a_file_of_another_user_stays_as_it_is(open_folder: Path) -> None:
    file = open_folder / "homebot.toml"
    file.write_text("old")
    open_folder.chmod(0o777)
    with nobody(), pytest.raises(PermissionError):
        replace_file(file, b"new")
    assert (file.read_text(), [path.name for path in open_folder.iterdir()]) == ("old", ["homebot.toml"])
