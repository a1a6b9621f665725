"""Features: each is data until it is used, says what it offers, and is known to no other module."""

import ast
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from tests.recorded_house import HOUSE
from tests.source_trees import source_trees

from homebot.apps import App
from homebot.bridges.rosapi import doctor
from homebot.bridges.rosbridge.services import usual_timeout
from homebot.cli import main
from homebot.config import Config, parse_config
from homebot.devices import QUERY_DEVICES, QueryDevices
from homebot.devices.own_services import CORE_SERVICES, right_to_call
from homebot.devices.query.term_messages import query_terms
from homebot.devices.services import Found, QueryDevicesRequest, QueryDevicesResponse
from homebot.errors import UsageError
from homebot.feature import Feature, all_features, find_features, load
from homebot.graph import Graph, Node
from homebot.messages.std_srvs import SuccessResponse, Trigger
from homebot.rights import OfferedService
from homebot.runtime import Runtime
from homebot.runtime.plan import make_plan
from homebot.words.queries import parse_query

FEATURES = {feature.name: feature for feature in all_features()}
ROOT = Path(__file__).parents[1] / "src/homebot"


SERVICES = {service.name: name for name, feature in FEATURES.items() for service in feature.services}
SERVICE = re.compile("|".join(rf"{service}(?![\w/])" for service in SERVICES) or "(?!)")


def services_in(text: str) -> list[str]:
    """The features whose services *text* spells."""
    return [SERVICES[found] for found in SERVICE.findall(text)]


@pytest.fixture
def other_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder of Python's path with the package ``acme``, whose feature is at an entry point."""
    info = tmp_path / "acme-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: acme\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[homebot.features]\nacme = acme:FEATURE\n")
    monkeypatch.syspath_prepend(tmp_path)
    find_features.cache_clear()
    yield tmp_path
    monkeypatch.undo()
    find_features.cache_clear()
    find_features()
    sys.modules.pop("acme", None)


def paths(feature: Feature) -> list[str]:
    """All that a feature names as ``module:name``."""
    own = (
        feature.server,
        feature.routes,
        feature.checks,
        feature.runs,
        feature.over_zenoh,
        feature.explains,
        feature.adds_to_why,
        feature.adds_to_why_not,
        *(verb.add_arguments for verb in feature.verbs.values()),
    )
    return list(filter(None, own))


@pytest.mark.parametrize("feature", FEATURES.values(), ids=list(FEATURES))
def test_all_that_a_feature_names_is_in_its_folder_and_its_services_need_the_right_that_it_says(
    feature: Feature,
) -> None:
    for path in paths(feature):
        assert path.startswith(f"homebot.features.{feature.name}.")
        load(path)
    for service in feature.services:
        assert right_to_call(service.name) is service.right


@pytest.mark.parametrize("feature", FEATURES.values(), ids=list(FEATURES))
def test_the_tools_of_a_feature_are_in_its_folder(feature: Feature) -> None:
    if feature.tools:
        pytest.importorskip("mcp")
        assert feature.tools.startswith(f"homebot.features.{feature.name}.")
        load(feature.tools)


def test_a_service_without_a_right_cannot_be_written_down() -> None:
    with pytest.raises(TypeError, match="right"):
        OfferedService("/devices/dance")  # type: ignore[call-arg]


@pytest.mark.parametrize("name", FEATURES)
def test_no_app_has_the_name_of_a_feature(name: str) -> None:
    config = parse_config({"apps": {name: {"class": "homebot.apps.lights_out:LightsOut"}}}, "homebot.toml")
    plan = make_plan(config)
    assert [*plan.left_out] == [f"apps.{name}"]
    assert "is the name of one of homebot's own nodes" in str(plan.left_out[f"apps.{name}"])
    assert not plan.apps


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("FEATURE = Feature(name='acme', verbs={'dance': Verb('dance', 'acme:dance')})", ""),
        ("FEATURE = 1 / 0", "ZeroDivisionError"),
        ("raise SystemExit(3)", "it calls sys.exit"),
        ("FEATURE = 'acme'", "is 'acme', not a Feature of that name"),
        ("FEATURE = Feature(name='goals')", "not a Feature of that name"),
        (
            "FEATURE = Feature(name='acme', services=(OfferedService('/devices/achieve', Right.READ, 'a/srv/A'),))",
            "offers the service /devices/achieve, as the feature goals does",
        ),
    ],
)
@pytest.mark.rooms("goals")
def test_a_feature_of_another_package_is_found_and_a_broken_one_stops_nothing(
    other_package: Path, text: str, problem: str, capsys: pytest.CaptureFixture[str]
) -> None:
    (other_package / "acme.py").write_text(
        f"from homebot.feature import Feature, Verb\nfrom homebot.rights import OfferedService, Right\n{text}\n"
    )
    found = find_features()
    assert found.features.keys() == {*FEATURES, *([] if problem else ["acme"])}
    assert found.problems.keys() == ({"acme"} if problem else set())
    assert problem in found.problems.get("acme", "")
    if problem:  # a table that is perhaps its own is left out with it
        left_out = make_plan(parse_config({"acme": {"bright": True}}, "homebot.toml")).left_out
        assert [*left_out] == ["features.acme", "acme"]
        assert problem in str(left_out["acme"])
        assert main(["acme"]) == 1
        assert problem in capsys.readouterr().err


def test_the_list_of_features_loads_nothing_of_them() -> None:
    code = "import sys; from homebot.feature import all_features; all_features(); print(*sys.modules, sep='\\n')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = done.stdout.split()
    assert {one for one in loaded if one.startswith("homebot.features.")} == {
        f"homebot.features.{one}" for one in FEATURES
    }
    assert not {"pydantic", "asyncio", "homebot.devices"}.intersection(loaded)


def test_no_module_outside_its_folder_imports_a_feature_names_a_module_of_it_or_spells_its_service() -> None:
    """Not even in a function, or for the type checker; the protocol that others speak is in ``devices``."""
    found = []
    for path, tree in source_trees().items():
        own = path.split("/")[1] if path.startswith("features/") else ""
        prose = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
        for node in ast.walk(tree):
            texts = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            texts += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in prose:
                texts.append(node.value)
            for text in texts:
                named = {*services_in(text), *re.findall(r"homebot\.features\.(\w+)", text)} - {own}
                if named and path != "devices/names.py":
                    found.append(f"{path}: {text}")
    assert found == []


def test_no_script_of_the_page_imports_that_of_a_feature_or_spells_its_service() -> None:
    """The scripts of ``web`` and the feature ``page`` are two halves of one thing, and speak with each other."""
    source, features = ROOT / "web/source", ROOT / "features"
    made = {"features.js", "languages"}  # by collect.js, which runs in Node
    found = []
    for script in ({*source.rglob("*.js")} - {source / "collect.js"}).union(features.glob("*/page/*.js")):
        own = script.relative_to(features).parts[0] if script.is_relative_to(features) else "page"
        text = script.read_text()
        found += [f"{script}: {name}" for name in services_in(text) if name != own]
        for path in re.findall(r'(?:from |import |import\()"(\.[^"]+)"', text):  # from where `make page` copies it to
            folder = script.parent if own == "page" else source / "features" / own
            place = (folder / path).resolve().relative_to(source)
            is_own = place.parts[:2] == ("features", own)
            file = features / own / "page" / place.name if is_own else source / place
            if not file.exists() and place.parts[0] not in made:
                found.append(f"{script}: {path}")
    assert found == []


def test_no_two_rows_of_services_are_of_one_name() -> None:
    names = [row.name for row in (*CORE_SERVICES, *(service for one in FEATURES.values() for service in one.services))]
    assert sorted(names) == sorted(set(names))


@pytest.mark.parametrize("name", ["/devices/achieve_words", "/control/perform", "/devices/command", "/scenes/apply"])
@pytest.mark.rooms("goals", "scenes")
def test_a_call_that_waits_for_devices_may_take_an_hour(name: str) -> None:
    assert (usual_timeout(name), usual_timeout("/discovery/query")) == (3600.0, 5.0)


@pytest.fixture
def checking_package(other_package: Path) -> None:
    """That package with a feature that has a question for the doctor."""
    (other_package / "acme.py").write_text(
        "from homebot.devices.findings import DeviceCheck, FindingKind\nfrom homebot.feature import Feature\n"
        "FEATURE = Feature(name='acme', checks='acme:checks')\n"
        "def checks(lost): yield DeviceCheck(FindingKind.NOTE, 'lux', lambda one, now: [f'no {lost}', one.name])\n"
    )
    find_features()


@pytest.mark.virtual_time
@pytest.mark.usefixtures("checking_package")
async def test_the_doctor_asks_the_questions_of_a_feature() -> None:
    def answer(request: QueryDevicesRequest) -> QueryDevicesResponse:
        is_asked = request.query == query_terms(parse_query("lux"))
        results = (Found(device=HOUSE[0], score=1.0, reasons=()),) if is_asked else ()
        return QueryDevicesResponse(success=True, message="", results=results, total=30 * len(results))

    graph = Graph()
    async with Node(graph, "rosapi") as rosapi, Node(graph, "asker") as asker:
        asker.create_service(QueryDevices, QUERY_DEVICES, answer)
        doctor.serve(rosapi)
        response = await asker.create_client(doctor.Examine, "/rosapi/doctor").call(doctor.ExamineRequest(), 4.5)
    assert [(row.what, row.why) for row in response.findings[0].rows] == [
        ("hall_lamp", "Hall lamp"),
        ("hall_lamp", "no []"),
    ]
    assert response.findings[0].hint == "; all: homebot find --limit 31 'lux'"


class Unheard(App):
    """Offers a service of the node of control that has no row."""

    async def run(self) -> None:
        """Offer it."""
        control = self.node.graph.get_node("/control")
        assert control is not None
        control.create_service(Trigger, "/control/unheard", lambda _: SuccessResponse(success=True, message=""))


async def test_a_start_refuses_a_service_of_its_own_without_a_right() -> None:
    runtime = Runtime(Config(), apps={"unheard": Unheard}, with_door=False)
    with pytest.raises(UsageError, match="services without a right: /control/unheard"):
        async with runtime:
            pytest.fail("it must not start")
