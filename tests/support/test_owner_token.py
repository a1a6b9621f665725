"""The owner's token: its file, and the proof that a program can read it."""

from pathlib import Path

import pytest

from homebot.errors import UsageError
from homebot.support.owner_token import OWNER_FILE, is_owner_proof, make_owner_token, owner_proof

KEY, PORT, NOW = "dGhlIHNhbXBsZSBub25jZQ==", 9090, 1_800_000_059.0


def test_it_is_made_once_for_its_user_alone_and_in_no_text(tmp_path: Path) -> None:
    file = tmp_path / "data" / OWNER_FILE
    made = make_owner_token(file)
    assert make_owner_token(file) == made
    assert (file.stat().st_mode & 0o777, len(made.secret)) == (0o600, 43)
    assert [one.name for one in file.parent.iterdir()] == [OWNER_FILE]
    assert made.secret not in repr(made)


def test_one_that_others_could_have_put_there_is_refused(tmp_path: Path) -> None:
    file = tmp_path / OWNER_FILE
    make_owner_token(file)
    file.chmod(0o622)
    with pytest.raises(UsageError, match="can be written by others; remove that permission: chmod go-w"):
        make_owner_token(file)
    file.chmod(0o600)
    tmp_path.chmod(0o777)
    with pytest.raises(UsageError, match="can be written by others"):
        make_owner_token(file)
    tmp_path.chmod(0o700)


def test_a_folder_that_cannot_be_written_is_told_with_the_next_step(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UsageError, match=r"cannot be written: .*; name another folder in HOMEBOT_DATA"):
        make_owner_token(tmp_path / "file" / OWNER_FILE)


def test_a_proof_is_for_one_handshake_with_one_door_within_a_minute() -> None:
    """A program that listens in homebot's place gains nothing that it could use there."""
    proof = owner_proof("secret", KEY, PORT, NOW)
    assert "secret" not in proof
    assert is_owner_proof(proof, "secret", KEY, PORT, NOW)
    assert is_owner_proof(proof, "secret", KEY, PORT, NOW + 60)
    assert not is_owner_proof(proof, "secret", KEY, PORT, NOW + 121)
    assert not is_owner_proof(proof, "another", KEY, PORT, NOW)
    assert not is_owner_proof(proof, "secret", "x3JJHMbDL1EzLkh9GBhXDw==", PORT, NOW)
    assert not is_owner_proof(proof, "secret", KEY, PORT + 1, NOW)
    assert not is_owner_proof("é" * 64, "secret", KEY, PORT, NOW)
    assert not is_owner_proof("secret", "secret", KEY, PORT, NOW)
