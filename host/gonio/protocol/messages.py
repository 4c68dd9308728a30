"""messages.py: names and sentences for the protobuf messages: what a request is called, what a reply means."""

from google.protobuf import descriptor_pb2

from gonio.protocol.generated import gonio_pb2 as pb
from gonio.units.errors import InstrumentFault, UsageError

GOOD_REPLIES = frozenset({pb.REPLY_OK, pb.REPLY_ACCEPTED})


def request_name(request: pb.Request) -> str:
    """The request's body by its name in gonio.proto, e.g. "motion_begin"."""
    return request.WhichOneof("body") or "empty request"


def state_name(state: int) -> str:
    """An InstrumentState in words, e.g. "ready"; numbers this program does not know are given as they are."""
    values = pb.InstrumentState.DESCRIPTOR.values_by_number
    return values[state].name.removeprefix("STATE_").lower() if state in values else f"state {state}"


def code_name(code: int) -> str:
    """A ReplyCode in words, e.g. "refused"."""
    values = pb.ReplyCode.DESCRIPTOR.values_by_number
    return values[code].name.removeprefix("REPLY_").lower().replace("_", " ") if code in values else f"code {code}"


def check_reply(what: str, code: int, text: str) -> None:
    """Raise when a reply's code is not good: UsageError for "not driver", InstrumentFault for all others."""
    if code in GOOD_REPLIES:
        return
    if code == pb.REPLY_NOT_DRIVER:
        raise UsageError(f"{what}: another program drives the instrument; end it, or stop it with gonio stop")
    raise InstrumentFault(text if code == pb.REPLY_FAULT and text else f"{what}: {code_name(code)}: {text}")


def event_schema() -> bytes:
    """A serialized FileDescriptorSet that explains Event, Reply and Request (for the raw log)."""
    files = descriptor_pb2.FileDescriptorSet()
    pb.DESCRIPTOR.CopyToProto(files.file.add())
    return bytes(files.SerializeToString())
