"""runner.py: runs a program's steps on a ready instrument: shutter, dark, operator, paths by knots and credits."""

from gonio.acquire.interrupt import ScanStopped
from gonio.acquire.operator import Operator
from gonio.acquire.progress import ScanProgress
from gonio.acquire.session import SECOND_NS, Session
from gonio.plan.program import DarkStep, OperatorStep, PathStep, Program, ShutterStep
from gonio.protocol.blocks import KNOTS_PER_FRAME, knot_payload
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.units.errors import InstrumentFault

# Feed hold may slow a path down, never to less than half for long: a credit comes every 100 ms.
PATH_TIMEOUT_FACTOR = 2.0
PATH_TIMEOUT_EXTRA_NS = 20 * SECOND_NS
FAULT_TIMEOUT_NS = SECOND_NS  # the sentence follows the path's end at once
LOG_ERROR, LOG_WARNING = 3, 4  # as syslog; firmware/port/log.h
_ACTIONS = {"sample_removed": pb.OPERATOR_SAMPLE_REMOVED, "sample_mounted": pb.OPERATOR_SAMPLE_MOUNTED}


class Runner:
    """One run of a program. The client's events pass through `take_event`."""

    def __init__(self, session: Session, operator: Operator, progress: ScanProgress) -> None:
        self._session = session
        self._client = session.client
        self._operator = operator
        self._progress = progress
        self._ends: dict[int, pb.PathState] = {}
        self._complaint = ""  # the firmware's last error in its log

    def take_event(self, event: pb.Event) -> None:
        """Note path ends and complaints; show progress."""
        body = event.WhichOneof("body")
        if body == "path" and event.path.end != pb.PATH_RUNNING:
            self._ends[event.path.path_id] = event.path
        elif body == "log":
            if event.log.level <= LOG_ERROR:
                self._complaint = event.log.text
            elif event.log.level <= LOG_WARNING and self._client.fault is None:  # what follows a fault explains nothing
                self._progress.say(event.log.text)
        elif body == "status" and event.status.state == pb.STATE_MOVING:
            self._progress.path_time(event.status.path_time_ns)

    def run(self, program: Program) -> None:
        """Run all steps. Raises InstrumentFault with the firmware's sentence, or ScanStopped."""
        for step in program.steps:
            match step:
                case OperatorStep():
                    self._operator.confirm(step, self._client.step)
                    self._client.request(operator_done=pb.OperatorDone(action=_ACTIONS[step.action]))
                case ShutterStep():
                    self._session.shutter(step.open)
                case DarkStep():
                    self._stand_still(step)
                case PathStep():
                    self._fly(step)

    def _stand_still(self, step: DarkStep) -> None:
        self._progress.begin("dark", step.duration_s)
        end_ns = self._client.link_time_ns + round(step.duration_s * SECOND_NS)
        self._client.wait_until(
            lambda: self._client.link_time_ns >= end_ns, round(step.duration_s * SECOND_NS) + SECOND_NS, "dark"
        )
        self._progress.end()

    def _fly(self, step: PathStep) -> None:
        self._progress.begin(step.name, step.duration_s)
        self._ends.pop(step.path_id, None)
        total = len(step.knots)
        self._client.request(motion_begin=pb.MotionBegin(path_id=step.path_id, knot_count=total, start=True))
        sent = 0

        def over() -> bool:
            nonlocal sent
            status = self._session.status()
            granted = min(status.knot_credit, total) if status.path_id == step.path_id else 0
            while sent < granted:
                part = step.knots[sent : min(sent + KNOTS_PER_FRAME, granted)]
                self._client.send_knots(knot_payload(step.path_id, sent, part))
                sent += len(part)
            return step.path_id in self._ends

        timeout_ns = round(PATH_TIMEOUT_FACTOR * step.duration_s * SECOND_NS) + PATH_TIMEOUT_EXTRA_NS
        self._client.wait_until(over, timeout_ns, f"path {step.name}")
        self._judge(step, self._ends[step.path_id].end)
        self._progress.end()

    def _judge(self, step: PathStep, end: int) -> None:
        """Raise unless the path came to its end."""
        if end == pb.PATH_FINISHED:
            return
        if end == pb.PATH_STOPPED:
            if self._complaint:
                raise InstrumentFault(f"path {step.name}: {self._complaint}")
            raise ScanStopped("stopped by another program")
        if end == pb.PATH_EXPIRED:
            raise InstrumentFault(
                f"path {step.name}: the firmware heard nothing from this program in time and stopped the arm;"
                " continue with --resume"
            )
        # wait_until raises with the fault's own sentence as soon as it comes.
        self._client.wait_until(lambda: False, FAULT_TIMEOUT_NS, f"path {step.name} ended by a fault")
