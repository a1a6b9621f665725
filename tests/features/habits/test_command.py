"""``homebot suggest``."""

import pytest

from homebot.cli.main import main


@pytest.mark.parametrize("days", ["0", "-1", "61"])
def test_days_out_of_range_are_refused_with_the_range(capsys: pytest.CaptureFixture[str], days: str) -> None:
    with pytest.raises(SystemExit):
        main(["suggest", "--days", days])
    problem = f"argument --days: must be a whole number from 1 to 60, got '{days}'\n"
    assert capsys.readouterr().err.endswith(problem)
