"""test_full_disk_twin.py: the host's disk fills up in a scan: the instrument is stopped, and the log can go on."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from twin_runs import GIVE_UP_S, journal, path_ends, run, write_inputs

from gonio.protocol.generated import gonio_pb2 as pb
from gonio.rawlog.reader import read_rawlog
from gonio.rawlog.segment_reader import read_segment
from gonio.rawlog.segments import existing_segments

pytestmark = pytest.mark.twin
ROOM_BYTES = 2_500_000  # of eleven million: it ends on the coarse path, in motion
# The kernel refuses what would make a file larger (EFBIG), as a full disk does; Python ignores the signal.
LIMITED = (
    "import resource, sys; resource.setrlimit(resource.RLIMIT_FSIZE, ({room}, {room}));"
    " from gonio.cli import main; sys.exit(main.run(sys.argv[1:]))"
)


def test_a_full_disk_stops_the_instrument_and_the_scan_can_go_on(tmp_path: Path) -> None:
    plan, device = write_inputs(tmp_path)
    log, end = tmp_path / "raw.mcap", tmp_path / "journal.json"
    command = [sys.executable, "-c", LIMITED.format(room=ROOM_BYTES), "scan", plan, "-o", log, "--device", device]
    done = subprocess.run(
        [*map(str, command), "--twin-journal", str(end)],
        env=os.environ | {"XDG_RUNTIME_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=GIVE_UP_S,
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr == (
        f"gonio: {log}: cannot be written (File too large), so the scan ends here: free space, then continue with"
        " --resume\n"
    )
    account = journal(end)
    assert account["at_rest"]
    assert not account["shutter_open"]

    cut = read_segment(log)
    assert not cut.damaged
    assert not cut.complete
    assert log.stat().st_size == ROOM_BYTES
    assert path_ends(cut)
    assert [e.status.state for e in cut.events if e.HasField("status")][-1] == pb.STATE_MOVING

    status, _, err = run(tmp_path, "scan", plan, "-o", log, "--device", device, "--resume")
    assert (status, err) == (0, "")
    whole = read_rawlog(existing_segments(log))
    assert whole.problem is None
    assert len(whole.segments) == 2
