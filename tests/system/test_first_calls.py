"""No first call of a service loads modules while everything else in the house waits."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

_MOST = 0.05
"""Seconds of the processor in one turn of the loop, with compiled files as an installation has them."""


@pytest.mark.parametrize("order", [1, -1], ids=["by name", "by name from the last"])
def test_the_first_call_of_no_offered_service_holds_up_others(
    tmp_path_factory: pytest.TempPathFactory, order: int
) -> None:
    """A first goal took 86 ms; an order shows what the calls before it had loaded in the other."""
    compiled = tmp_path_factory.getbasetemp() / "compiled"
    _turns(order, compiled)  # the first run compiles
    turns = _turns(order, compiled)
    assert len(turns) > 50
    assert {name: seconds for name, seconds in turns.items() if seconds > _MOST} == {}


def _turns(order: int, compiled: Path) -> dict[str, float]:
    environment = {**os.environ, "PYTHONPYCACHEPREFIX": str(compiled)}
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    program = [sys.executable, "-m", "tests.system.first_calls", str(order)]
    output = subprocess.run(program, env=environment, check=True, capture_output=True, text=True).stdout
    lines = [line.split() for line in output.splitlines()]
    return {name: float(seconds) for seconds, name in lines}
