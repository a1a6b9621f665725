"""The container: its commands exist, and it is built where there is a tool and the image that it begins with."""

import json
import re
import shutil
import subprocess
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

from homebot.cli.main import make_parser

ROOT = Path(__file__).parents[1]
LINES = (ROOT / "Containerfile").read_text().replace("\\\n", " ").splitlines()


def words_of(instruction: str) -> list[str]:
    return [line.removeprefix(f"{instruction} ") for line in LINES if line.startswith(f"{instruction} ")]


def image() -> str:
    """Return the image that it begins with, unless another one is given by its digest."""
    assert words_of("FROM") == ["${BASE}"]
    (base,) = words_of("ARG")
    return base.removeprefix("BASE=")


def exec_form(instruction: str) -> list[str]:
    (text,) = words_of(instruction)
    words: list[str] = json.loads(text[text.index("[") :])
    return words


def test_the_commands_of_the_container_exist() -> None:
    for words in (exec_form("ENTRYPOINT") + exec_form("CMD"), exec_form("HEALTHCHECK")):
        assert words[0] == "homebot"
        assert make_parser(words[1:]).parse_args(words[1:]).command
    assert words_of("USER") == ["1000"]
    assert words_of("VOLUME") == words_of("WORKDIR") == ["/data"]  # doctor reads [door] of homebot.toml there


def test_the_image_keeps_compiled_files() -> None:
    """Pip makes them, and nobody who runs it can."""
    assert not [line for line in LINES if "--no-compile" in line or "PYTHONDONTWRITEBYTECODE" in line]
    assert any(line.startswith("RUN pip install ") for line in LINES)


def test_all_that_is_copied_is_there_and_not_left_out_of_the_context() -> None:
    kept = {line[1:] for line in (ROOT / ".dockerignore").read_text().splitlines() if line.startswith("!")}
    copied = {name for line in words_of("COPY") for name in line.split()[:-1]}
    assert copied == kept
    assert all((ROOT / name).exists() for name in copied)


def test_the_image_and_the_extras_are_those_of_the_project() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    (version,) = re.findall(r"python:(3\.\d+)-slim$", image())
    assert f"Programming Language :: Python :: {version}" in project["classifiers"]
    locked = re.findall(r"-r /source/requirements/(\w+)\.txt", " ".join(words_of("RUN")))
    assert locked == ["run", "all"]
    assert "all" in project["optional-dependencies"]


def test_the_guide_runs_the_container_with_what_it_needs() -> None:
    guide = (ROOT / "docs" / "operate.md").read_text()
    (command,) = re.findall(r"^podman run (?:.*\\\n)*.*", guide, re.MULTILINE)
    assert fnmatch(command, "*--network host*:/data homebot")
    assert "podman build --format docker " in guide  # its own format has no HEALTHCHECK
    assert "BUILDAH_FORMAT=docker $$engine build " in (ROOT / "Makefile").read_text()


def _tool() -> str:
    """Return a tool for containers that works and has the image; empty if there is none."""
    for tool in filter(shutil.which, ("podman", "docker")):
        command = [tool, "image", "inspect", image()]
        if not subprocess.run(command, capture_output=True, check=False, timeout=60).returncode:
            return tool
    return ""


@pytest.mark.skipif(not _tool(), reason="no podman or docker with the image that it begins with")
def test_the_container_is_built() -> None:
    command = [_tool(), "build", "--file", "Containerfile", "--tag", "homebot-test", "."]
    assert subprocess.run(command, cwd=ROOT, check=False, timeout=900).returncode == 0
    run = [_tool(), "run", "--rm", "homebot-test", "--version"]
    assert "homebot" in subprocess.run(run, capture_output=True, text=True, check=False, timeout=120).stdout
