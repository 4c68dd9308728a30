"""bench.py: the hot loops beside their peers in one run: a table and NAME.json files. `make bench` runs it."""

import json
import os
import resource
import statistics
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import google_crc32c
import numpy as np
from cells import spherical_cells
from reduction import reduction
from rows import machine, row, seconds

from gonio.protocol.frames import encode_frame
from gonio.protocol.generated import records
from gonio.rawlog.decode import decode_sample_blocks

ROOT = Path(__file__).resolve().parents[2]
SAMPLES_PER_BLOCK = 100


def decode() -> list[dict[str, Any]]:
    """Raw sample blocks to arrays, against a loop over struct.unpack."""
    block = np.zeros(1, records.SAMPLE_BLOCK_DTYPE)
    block["count"], block["period_ns"], block["window"] = SAMPLES_PER_BLOCK, 1e6, 1000
    rng = np.random.default_rng(1)
    payloads = []
    for number in range(50_000):
        block["first_sample"] = number * SAMPLES_PER_BLOCK
        body = rng.integers(0, 255, SAMPLES_PER_BLOCK * records.SAMPLE_DTYPE.itemsize, np.uint8)
        payloads.append(block.tobytes() + body.tobytes())
    few = payloads[:2000]
    record = struct.Struct("<iiihH")
    offset = records.SAMPLE_BLOCK_DTYPE.itemsize

    def plain() -> list[tuple[int, ...]]:
        return [values for payload in few for values in record.iter_unpack(payload[offset:])]

    ours = len(payloads) * SAMPLES_PER_BLOCK / seconds(lambda: decode_sample_blocks(payloads), 7) / 1e6
    peer = len(few) * SAMPLES_PER_BLOCK / seconds(plain, 5) / 1e6
    return [row("decode raw sample blocks", "M samples/s", ours, peer, "struct.iter_unpack", 7, high=True)]


def sampler() -> list[dict[str, Any]]:
    """Digitiser packets to sealed link frames on one core, against the same work by struct and google-crc32c."""
    program = os.environ.get("GONIO_BENCH_SAMPLER", str(ROOT / "build/native/firmware/gonio-bench-sampler"))
    with tempfile.TemporaryDirectory() as folder:
        files = {name: Path(folder) / name for name in ("frames", "packets")}
        arguments = [text for name, path in files.items() for text in (f"--{name}", str(path))]
        runs = [json.loads(subprocess.run([program, *arguments], check=True, capture_output=True).stdout)
                for _ in range(5)]  # fmt: skip
        frames, packets = (memoryview(files[name].read_bytes()) for name in ("frames", "packets"))
    samples = sum(judge_frames(frames))
    if samples != runs[0]["samples"]:
        raise SystemExit(f"gonio-bench-sampler: {samples} of {runs[0]['samples']} samples are in its frames")
    header, size = records.DIGITISER_PACKET_DTYPE.itemsize, records.SAMPLE_DTYPE.itemsize
    packet = header + size * int(np.frombuffer(packets, records.DIGITISER_PACKET_DTYPE, 1)["count"][0])
    block = struct.Struct("<QqdIIIIfIII")
    carrier = bytearray(b"\1" * len(frames))

    def peer() -> None:
        end = 0
        for number, at in enumerate(range(0, len(packets), 4 * packet)):
            parts = [packets[k + header : k + packet] for k in range(at, at + 4 * packet, packet)]
            count = sum(map(len, parts)) // size
            start = block.pack(number * count, number, 1000.0, number, count, 0, 0, 0.0, 1000, 0, 0)
            frame = encode_frame(records.FRAME_SAMPLES, number + 1, 0, b"".join([start, *parts]))
            carrier[end : end + len(frame)] = frame
            end += len(frame)

    ours = statistics.median(run["samples_per_s"] for run in runs) / 1e6
    return [row("digitiser packets to link frames", "M samples/s", ours, samples / seconds(peer, 5) / 1e6,
                "Python, struct + google-crc32c", 5, high=True)]  # fmt: skip


def judge_frames(frames: memoryview) -> Iterator[int]:
    """The samples of each frame; every checksum is made again by google-crc32c."""
    at, size = 0, records.FRAME_HEADER_DTYPE.itemsize
    while at < len(frames):
        header = np.frombuffer(frames, records.FRAME_HEADER_DTYPE, 1, at)[0]
        payload = frames[at + size : at + size + int(header["length"])]
        if google_crc32c.extend(google_crc32c.value(bytes(frames[at : at + 16])), bytes(payload)) != header["crc32c"]:
            raise SystemExit(f"gonio-bench-sampler: the frame at byte {at} has a wrong checksum")
        if header["kind"] == records.FRAME_SAMPLES:
            yield int(np.frombuffer(payload, records.SAMPLE_BLOCK_DTYPE, 1)["count"][0])
        at += size + len(payload)


def scan() -> list[dict[str, Any]]:
    """100,000 samples in virtual time: firmware and twin alone, then the whole command with Python included."""
    twin = os.environ.get("GONIO_TWIN", str(ROOT / "build/native/sim/gonio-twin"))
    alone = [json.loads(subprocess.run([f"{twin}-bench"], check=True, capture_output=True).stdout) for _ in range(3)]
    payloads = {run["payload_hash"] for run in alone}
    if len(payloads) != 1:
        raise SystemExit(f"gonio-twin-bench: the same seed gave different payloads: {sorted(payloads)}")
    gonio = str(Path(sys.executable).with_name("gonio"))
    scenarios = ROOT / "sim/scenarios"
    arguments = [str(ROOT / "docs/examples/bench.toml"), "--instrument", str(scenarios / "pairing-axes.toml")]
    arguments += ["--device", f"twin:{scenarios / 'pairing.toml'}"]
    with tempfile.TemporaryDirectory() as folder:
        number = iter(range(100))

        def whole() -> None:
            raw = Path(folder) / f"raw{next(number)}.mcap"
            environment = os.environ | {"XDG_RUNTIME_DIR": folder}
            command = [gonio, "scan", *arguments, "-o", str(raw)]
            subprocess.run(command, check=True, capture_output=True, env=environment)

        wall = seconds(whole, 3)
    virtual = statistics.median(run["virtual_s"] for run in alone)
    wall_alone = statistics.median(run["wall_s"] for run in alone)
    real = "the instrument in real time"
    return [
        row("firmware and twin, 100,000 samples", "s", wall_alone, virtual, real, 3, high=False),
        row("gonio scan, 100,000 samples, all included", "s", wall, virtual, real, 3, high=False),
    ]


def main() -> None:
    out = Path(sys.argv[1] if len(sys.argv) > 1 else "build/bench")
    out.mkdir(parents=True, exist_ok=True)
    lines = [f"{'':46} {'unit':12} {'ours':>10} {'peer':>10} {'ratio':>8}  peer"]
    for bench in (decode, sampler, spherical_cells, reduction, scan):
        rows = bench()
        text = json.dumps({"bench": bench.__name__, "machine": machine(), "rows": rows}, indent=1)
        (out / f"{bench.__name__}.json").write_text(text + "\n")
        for line in rows:
            peer, ratio = ("not run", "-") if line["peer"] is None else (f"{line['peer']:.3g}", f"{line['ratio']:.3g}")
            lines.append(
                f"{line['name']:46} {line['unit']:12} {line['ours']:10.3g} {peer:>10} {ratio:>8}  {line['peer_name']}"
            )
    lines.append(f"peak memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MiB")
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
