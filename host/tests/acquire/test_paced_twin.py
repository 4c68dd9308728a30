"""test_paced_twin.py: the twin in real time, as an instrument on the network: info, home, stop from elsewhere, end."""

import json
import os
import select
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from twin_runs import QUIET, journal, run

from gonio.link.client import Client
from gonio.link.connect import open_transport
from gonio.link.device import parse_device
from gonio.protocol.generated import gonio_pb2 as pb

pytestmark = pytest.mark.twin
GIVE_UP_S = 60.0
GONIO = [sys.executable, "-m", "gonio.cli.main"]


def start(folder: Path, *arguments: str | Path) -> subprocess.Popen[str]:
    """Start gonio, its control socket in `folder`."""
    folder.mkdir(exist_ok=True)
    return subprocess.Popen(
        [*GONIO, *map(str, arguments)],
        env=os.environ | {"XDG_RUNTIME_DIR": str(folder)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@pytest.fixture
def twin(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """`gonio twin run` in real time: the process, and the device name of the address that it prints."""
    scenario = tmp_path / "scenario.toml"
    scenario.write_text(QUIET)
    process = start(tmp_path, "twin", "run", scenario, "--journal", tmp_path / "journal.json")
    try:
        assert process.stdout
        assert select.select([process.stdout], [], [], GIVE_UP_S)[0], "the twin said nothing"
        word, address = process.stdout.readline().split()
        assert word == "listening"
        yield process, f"tcp://{address}"
    finally:
        process.kill()
        process.communicate()


def wait_for_state(device: str, state: pb.InstrumentState) -> None:
    """Ask as a visitor until the instrument is in a state; each question waits for its answer."""
    give_up_s = time.monotonic() + GIVE_UP_S
    with Client(open_transport(parse_device(device)), pb.ROLE_VISITOR) as client:
        while client.request(get_info=pb.GetInfo()).info.state != state:
            assert time.monotonic() < give_up_s, f"the instrument never came to state {state}"


def test_home_on_the_network_is_stopped_by_a_visitor(twin: tuple[subprocess.Popen[str], str], tmp_path: Path) -> None:
    process, device = twin
    status, out, err = run(tmp_path, "info", "--device", device, "--json")
    assert (status, err) == (0, "")
    assert json.loads(out)["state"] == "unconfigured"
    assert not json.loads(out)["driver_connected"]

    home = start(tmp_path / "driver", "home", "--device", device)
    wait_for_state(device, pb.STATE_HOMING)
    # Another user's: it finds no process that drives, and asks the instrument itself.
    assert run(tmp_path, "stop", "--device", device) == (0, f"{device} stops\n", "")
    out, err = home.communicate(timeout=GIVE_UP_S)
    assert (home.returncode, out) == (130, "")
    assert err == "gonio: stopped by another program (gonio stop)\n"
    assert json.loads(run(tmp_path, "info", "--device", device, "--json")[1])["state"] == "unhomed"

    process.send_signal(signal.SIGTERM)
    assert process.wait(GIVE_UP_S) == 0
    account = journal(tmp_path / "journal.json")
    assert account["end_reason"] == "ended by a signal"
    assert account["at_rest"]
    assert not account["shutter_open"]
    arm_elevation_deg = account["position_deg"][3]
    assert -85.0 < arm_elevation_deg < 0.0  # on its way to the switch, the first axis to home
