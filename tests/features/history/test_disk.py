"""What a disk has to bear: bytes written, the size of a year, and a kill at any moment."""

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from tests.sizes import size

from homebot.features.history.batch import Batch, Series
from homebot.features.history.history_file import HistoryFile
from homebot.features.history.settings import KeepSettings

pytestmark = [pytest.mark.slow, pytest.mark.skipif(sys.platform != "linux", reason="/proc counts the bytes")]

START = 1_767_225_600_000
BATCH = 300_000
EVERY = 10_000
SENSORS = 20
HOURS = 26


def bytes_written() -> int:
    """Bytes that this process had written to the disk, whole pages, the log of the database included."""
    fields = dict(line.split(": ") for line in Path("/proc/self/io").read_text(encoding="ascii").splitlines())
    return int(fields["wchar"])


def write_hours(file: HistoryFile, sensors: int, hours: int) -> None:
    """Write *sensors* that report every ten seconds."""
    chance = random.Random(1)  # noqa: S311 - a simulation
    values = [20.0] * sensors
    batch = Batch(new=[Series(one, (f"s{one}", "", "temperature"), "°C") for one in range(sensors)])
    for begin in range(START, START + hours * 3_600_000, BATCH):
        for at in range(begin, begin + BATCH, EVERY):
            for one in range(sensors):
                values[one] = round(values[one] + chance.choice((-0.1, 0.0, 0.1)), 1)
                batch.add(one, at + one, values[one])
        file.write(batch, begin + BATCH)
        batch = Batch()


def test_a_day_of_100_sensors_writes_less_than_20_mb_and_a_year_takes_less_than_200(tmp_path: Path) -> None:
    """Of a fifth of them; a year has 30 days of five minutes, 2 days of values and 365 rows of hours."""
    file = HistoryFile(tmp_path / "history.sqlite", KeepSettings())
    file.open(0.0)
    file.load()
    before = bytes_written()
    write_hours(file, SENSORS, HOURS)
    written = (bytes_written() - before) * (100 / SENSORS) * (24 / HOURS)
    sizes = {
        table: file.connection.execute(f"SELECT avg(length(d) + 12) FROM {table}").fetchone()[0]  # noqa: S608 - our names
        for table in ("raw", "five", "day")
    }
    file.close()
    year = 100 * 1.15 * (48 * sizes["raw"] + 30 * 24 * sizes["five"] + 365 * sizes["day"])
    assert written < 20e6, f"{written / 1e6:.1f} MB a day"
    assert year < 200e6, f"{year / 1e6:.1f} MB a year, {sizes}"


KILLED = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from test_disk import KeepSettings, HistoryFile, write_hours
file = HistoryFile(Path({path!r}), KeepSettings())
file.open(0.0)
file.load()
print("ready", flush=True)
write_hours(file, 20, 1000)
"""


def test_a_kill_while_it_writes_damages_nothing(tmp_path: Path) -> None:
    """All batches but the last are there."""
    path = tmp_path / "history.sqlite"
    code = KILLED.format(tests=str(Path(__file__).parent), path=str(path))
    for turn in range(size(2, 4)):
        with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert process.stdout.readline() == "ready\n"
            time.sleep(0.3 + turn / 10)
            os.kill(process.pid, signal.SIGKILL)
        file = HistoryFile(path, KeepSettings())
        assert file.open(0.0) is None
        assert len(file.load().series) == SENSORS
        assert file.connection.execute("SELECT count(*) FROM recent").fetchone()[0] >= 1
        file.close()
