import pytest

from homebot.conventions.description import DescribedPart
from homebot.conventions.homeassistant.config import DiscoveryConfig
from homebot.conventions.homeassistant.sensors import build_camera, build_image
from homebot.errors import RefusedError, WireError


@pytest.mark.parametrize(
    ("part", "service_type"),
    [
        (build_camera(DiscoveryConfig("camera", "door", {"topic": "frigate/door/snapshot"})), "camera"),
        (build_image(DiscoveryConfig("image", "map", {"image_topic": "frigate/door/snapshot"})), "camera"),
        (build_image(DiscoveryConfig("image", "map", {"url_topic": "frigate/door/snapshot"})), "camera"),
    ],
)
def test_a_picture_is_known_to_be_there_but_not_listened_to(part: DescribedPart, service_type: str) -> None:
    assert part.part.service_type == service_type
    assert [(one.name, one.readable, one.settable) for one in part.part.capabilities] == [("image", False, False)]
    assert part.part.reads == ("frigate/door/snapshot",)
    assert part.codec.topics() == ()
    with pytest.raises(RefusedError):
        part.codec.write("image", "x")


def test_a_picture_without_a_topic_is_refused() -> None:
    with pytest.raises(WireError, match="topic"):
        build_camera(DiscoveryConfig("camera", "door", {}))
    with pytest.raises(WireError, match="image_topic"):
        build_image(DiscoveryConfig("image", "map", {}))
