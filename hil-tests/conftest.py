"""conftest.py: `--rig FILE`, one boot for all that is selected, and the four outcomes counted in the summary."""

from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest

from harness.outcomes import BrokenRigError, Outcome, Tally
from harness.results import Result, ScenarioFailedError
from harness.rig import Rig, RigFileError, load_rig
from harness.session import ROOT, SystemLane

HERE = Path(__file__).resolve().parent
_RIG = pytest.StashKey[Rig]()
_TALLY = pytest.StashKey[Tally]()
_LANE = pytest.StashKey[SystemLane]()
_BROKEN = pytest.StashKey[bool]()


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("rig")
    group.addoption("--rig", default=str(HERE / "rigs" / "vm.toml"), metavar="FILE", help="rig file; default vm.toml")
    group.addoption("--build", default=str(ROOT / "build" / "native"), metavar="DIR", help="where goniod was built")


def pytest_configure(config: pytest.Config) -> None:
    config.addinivalue_line("markers", "scenario(name): the test looks at what this scenario left")
    try:
        config.stash[_RIG] = load_rig(Path(config.getoption("--rig")).resolve())
    except RigFileError as error:
        raise pytest.UsageError(str(error)) from error
    config.stash[_TALLY] = Tally()


def pytest_collection_finish(session: pytest.Session) -> None:
    """Only what the selected tests look at is run."""
    wanted = [marker.args[0] for item in session.items if (marker := item.get_closest_marker("scenario"))]
    config = session.config
    rig = config.stash[_RIG]
    lane = "soak" if "soak" in wanted else "system"
    build = Path(config.getoption("--build")).resolve()
    results = ROOT / "build" / "hil" / rig.path.stem
    limit_s = float(rig.settings.get(f"{lane}_limit_s", 0.0))  # a bench has no machine to boot
    config.stash[_LANE] = SystemLane(rig, build, results / lane, limit_s, wanted)


@pytest.fixture
def rig(pytestconfig: pytest.Config) -> Rig:
    """The rig; the test is not run if there is none."""
    chosen = pytestconfig.stash[_RIG]
    absent = chosen.absent()
    if absent:
        pytest.skip(f"not run: {absent}")
    return chosen


@pytest.fixture
def result(request: pytest.FixtureRequest, rig: Rig) -> Result:
    """What the test's scenario left. The test fails if the scenario's own steps did."""
    marker = request.node.get_closest_marker("scenario")
    assert marker is not None, "mark the test with @pytest.mark.scenario(NAME)"
    if rig.kind != "vm":
        pytest.skip(f"not run: {rig.path.name} has no twin to play {marker.args[0]}")
    left = request.config.stash[_LANE].result(marker.args[0])
    left.require_steps()
    return left


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if call.excinfo is not None and call.excinfo.errisinstance((BrokenRigError, ScenarioFailedError)):
        report.longrepr = str(call.excinfo.value)  # where in the harness it was noticed tells nobody anything
    broken = call.excinfo is not None and call.excinfo.errisinstance(BrokenRigError)
    item.stash[_BROKEN] = broken
    if "rig" in getattr(item, "fixturenames", ()):
        outcome: Outcome | None = "passed" if report.when == "call" else None
        if report.skipped:
            outcome = "not run"
        elif report.failed:
            outcome = "broken rig" if broken else "failed"
        if outcome is not None:
            item.config.stash[_TALLY].add(item.nodeid, outcome)
    if broken:
        report.user_properties.append(("broken rig", True))
    return report


def pytest_report_teststatus(report: pytest.TestReport | Any) -> tuple[str, str, str] | None:
    """A broken rig shows as B and has its own count; the run still ends with an error."""
    if ("broken rig", True) in getattr(report, "user_properties", ()):
        return "broken rig", "B", "BROKEN RIG"
    return None


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    tally, rig = config.stash[_TALLY], config.stash[_RIG]
    terminalreporter.section(tally.line(rig.path.name))
    for report in terminalreporter.stats.get("broken rig", []):
        terminalreporter.line(f"{report.nodeid}: {report.longrepr}")
