"""The files of a bag."""

from pathlib import Path

import pytest

from homebot.errors import UsageError
from homebot.features.bags.bag_files import bag_files


def test_a_folder_without_files_is_no_bag(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"has no MCAP file$"):
        bag_files(tmp_path)


@pytest.mark.parametrize("name", ["day_0.db3", "day_0.mcap.zstd"])
def test_a_bag_of_another_storage_has_to_be_converted(tmp_path: Path, name: str) -> None:
    (tmp_path / name).touch()
    with pytest.raises(UsageError, match=f"has no MCAP file, but {name}: convert it with `ros2 bag convert`"):
        bag_files(tmp_path)
