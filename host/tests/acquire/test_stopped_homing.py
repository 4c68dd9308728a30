"""test_stopped_homing.py: a stop while the axes home is a stop, not a fault, whatever the firmware calls it."""

from collections.abc import Callable
from pathlib import Path

import pytest
from fake_firmware import Connect, FakeFirmware
from tiny_scan import run_tiny_scan

from gonio.acquire.interrupt import Interrupt, ScanStopped, a_stop_is_no_fault
from gonio.cli import main
from gonio.link.client import Client
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records
from gonio.units.errors import InstrumentFault

Device = Callable[..., tuple[FakeFirmware, str]]


def stopped_while_homing(fake: FakeFirmware, request: pb.Request) -> pb.Reply | None:
    """Home: a visitor's stop, and the end of the operation with the firmware's own words, in one go."""
    if request.WhichOneof("body") == "home":
        fake.put(records.FRAME_REPLY, pb.Reply(id=request.id, code=pb.REPLY_ACCEPTED).SerializeToString())
        fake.event(stop=pb.Stop(reason="gonio stop"))
        fake.event(done=pb.OperationDone(request_id=request.id, code=pb.REPLY_FAULT, text="stopped by request"))
        return pb.Reply(code=pb.REPLY_OK)
    return None


def test_a_visitors_stop_in_a_scan(device: Device, tmp_path: Path) -> None:
    fake, name = device(on_request=stopped_while_homing)
    fake.status.position_known_mask = 0
    with pytest.raises(ScanStopped, match=r"stopped by another program \(gonio stop\): the arm is at rest"):
        run_tiny_scan(tmp_path, name)
    assert [r.WhichOneof("body") for r in fake.requests].count("stop") == 1


@pytest.mark.parametrize(
    ("fault", "error"), [(pb.Fault(sentence="node 3 is lost"), InstrumentFault), (None, ScanStopped)]
)
def test_a_fault_is_a_fault_though_somebody_asked_to_stop(
    connect: Connect, fault: pb.Fault | None, error: type[Exception]
) -> None:
    client, interrupt = Client(connect()[1]), Interrupt()
    interrupt.ask("another program")
    client.fault = fault
    with pytest.raises(error), a_stop_is_no_fault(interrupt, client):
        raise InstrumentFault("homing ended")


def test_a_visitors_stop_of_gonio_home(
    device: Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    fake, name = device(on_request=stopped_while_homing)
    fake.status.position_known_mask = 0
    assert main.run(["home", "--device", name]) == 130
    assert capsys.readouterr().err == "gonio: stopped by another program (gonio stop)\n"
