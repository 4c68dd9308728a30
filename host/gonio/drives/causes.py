"""causes.py: what the load found, and the likely cause in words; docs/hardware.md explains each rule."""

from dataclasses import dataclass
from fractions import Fraction

from gonio.drives.findings import Finding, Grade
from gonio.drives.load import LoadRecord, NodeRecord

BUSY = 0.7  # of the bus: beyond it arbitration alone makes frames late, and error frames have no room
UNEVEN = 0.2  # of the period: so much spread of the SYNCs comes from the host, never from a bus that is not full
UNDER_VOLTAGE = range(0x3000, 0x4000)
HEARTBEAT_MISSED, SYNC_LENGTH, RPDO_TIMEOUT = 0x8130, 0x8240, 0x8250


@dataclass(frozen=True)
class Percentiles:
    """Of absolute values, in microseconds."""

    p50_us: float
    p99_us: float
    max_us: float


def percentiles(values: list[float]) -> Percentiles | None:
    """Nearest rank; None of nothing."""
    if not values:
        return None
    ranked = sorted(abs(value) for value in values)

    def at(share: Fraction) -> float:
        return ranked[max(0, -(-share.numerator * len(ranked) // share.denominator) - 1)]

    return Percentiles(at(Fraction(1, 2)), at(Fraction(99, 100)), ranked[-1])


def frame_bits(data_bytes: int) -> int:
    """A data frame with an 11-bit identifier, worst case of stuffing, with the space to the next."""
    stuffed = 34 + 8 * data_bytes  # from start of frame to the end of the CRC
    return 47 + 8 * data_bytes + (stuffed - 1) // 4


def bus_load(period_us: int, frames: list[int], bitrate: int) -> float:
    """Share of the bus that frames with so many data bytes take in every period, at worst."""
    return sum(frame_bits(n) for n in frames) / (bitrate * period_us * 1e-6)


def judge(record: LoadRecord, load: float | None) -> list[Finding]:
    """Findings about the bus and each node, then the likely causes."""
    findings = [finding for node in record.nodes.values() for finding in _node(node, record.window_us)]
    if record.foreign_syncs:
        text = f"{record.foreign_syncs} SYNCs that are not ours: another SYNC producer, or SYNCs delivered twice"
        findings.append(Finding(Grade.WRONG, "bus", "0x1005", text))
    if record.errors.frames:
        counters = record.errors.counters
        told = f", error counters {counters[0]} (send) and {counters[1]} (receive)" if counters else ""
        text = f"{record.errors.frames} error frames, worst state {record.errors.state_words}{told}"
        findings.append(Finding(Grade.WRONG, "bus", "", text))
    if record.sends_failed:
        text = f"{record.sends_failed} frames were not taken by the interface"
        findings.append(Finding(Grade.WRONG, "bus", "", text))
    if record.echoes_lost and record.echoes_seen:
        findings.append(Finding(Grade.WRONG, "bus", "", f"{record.echoes_lost} SYNCs did not come back as echo"))
    if not record.echoes_seen:
        text = "this interface echoes nothing: jitter and lateness are not judged; goniod's own must echo"
        findings.append(Finding(Grade.NOTE, "bus", "", text))
    findings += [Finding(Grade.NOTE, "likely cause", "", text) for text in likely_causes(record, load)]
    return findings


def _node(node: NodeRecord, window_us: int) -> list[Finding]:
    where = f"node {node.node}"
    findings = []
    for count, what in (
        (node.lost, "lost"),
        (node.late, f"later than {window_us} us after the SYNC's echo"),
        (node.duplicate, "more than one per SYNC"),
    ):
        if count:
            findings.append(Finding(Grade.WRONG, where, "0x1800", f"{count} TPDOs {what}"))
    for code in sorted(set(node.emergencies)):
        text = f"EMCY 0x{code:04X}, {node.emergencies.count(code)} times"
        findings.append(Finding(Grade.WRONG, where, "0x603F", text))
    if node.boot_ups:
        findings.append(Finding(Grade.WRONG, where, "", f"started anew {node.boot_ups} times during the load"))
    return findings


def likely_causes(record: LoadRecord, load: float | None) -> list[str]:
    """The rules, most fundamental first; a bus that does not work at all has one cause only."""
    nodes = list(record.nodes.values())
    heard = sum(node.received for node in nodes)
    errors = record.errors
    if heard == 0:
        if errors.protocol or (errors.worst_state == 3 and not errors.no_acknowledge):
            return ["bit rate: frames are seen but none is understood; set interface and drives alike"]
        if errors.no_acknowledge or record.sends_failed:
            return ["power, cable or bit rate: nobody acknowledges a frame; are the drives on, is the bus connected?"]
        return ["the drives answer SDO and not the SYNC: is 0x1005 0x80, do they support synchronous TPDOs?"]
    causes = []
    emergencies = {code for node in nodes for code in node.emergencies}
    if any(node.boot_ups for node in nodes) or any(code in UNDER_VOLTAGE for code in emergencies):
        causes.append("power: a drive started anew or reports its voltage; check supply and cable cross-section")
    if errors.protocol or errors.worst_state >= 2:
        causes.append(
            "termination or cable: frames are damaged on the way; with the power off measure 60 ohm between CAN_H and "
            "CAN_L, check length and stubs for the bit rate, and the common ground"
        )
    if errors.overflows or record.sends_failed:
        causes.append(
            "CAN interface: its queues overflow; a controller with deeper ones, or a longer queue (txqueuelen)"
        )
    lost = [node for node in nodes if node.lost]
    bunched = all(node.lost and node.duplicate for node in nodes)
    if bunched:
        causes.append(
            "the interface delivers in bunches: TPDOs of several cycles at once; a network or serial adapter does so, "
            "and the bus may be sound: measure with the controller that goniod uses"
        )
    elif record.lost_together:
        causes.append(
            f"what all drives share: {record.lost_together} cycles without any TPDO; the interface, its plug, the "
            "first stretch of cable"
        )
    elif len(lost) == 1 and len(nodes) > 1:
        causes.append(f"node {lost[0].node} alone loses TPDOs: its plug, stub and supply, its firmware version")
    elif lost and not causes:
        causes.append(
            "single TPDOs are lost at several drives and no error is reported: does the interface drop frames?"
        )
    if any(node.duplicate for node in nodes) and not bunched:
        causes.append("two drives with one node id, or a TPDO that is also sent by timer (0x1800:05) or on change")
    if any(node.late for node in nodes):
        if load is not None and load > BUSY:
            causes.append(f"bus load: up to {100 * load:.0f} % of the bit rate; raise the bit rate or sync_period_us")
        else:
            causes.append("late TPDOs on a bus with room: the drive answers slowly; raise sync_window_us")
    if HEARTBEAT_MISSED in emergencies:
        causes.append("EMCY 0x8130: a heartbeat that 0x1016 waits for is missing; goniod is off during this check")
    if SYNC_LENGTH in emergencies:
        causes.append("EMCY 0x8240: the drive does not take a SYNC with counter; check 0x1019")
    if RPDO_TIMEOUT in emergencies:
        causes.append("EMCY 0x8250: an RPDO deadline ran out that 0x1400:05 does not show; look in the drive's manual")
    spread = percentiles(record.echo_errors_us)
    if record.skipped or (spread is not None and spread.p99_us > UNEVEN * record.period_us):
        causes.append("this host is uneven (its Python is not the firmware): that alone says nothing about the bus")
    return causes
