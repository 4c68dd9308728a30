"""test_vectors.py: the golden bytes of protocol/vectors, which the firmware's tests pass too."""

import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from gonio.protocol.blocks import knot_block, knot_payload, pose_block, sample_block
from gonio.protocol.frames import FrameDecoder, FrameError, encode_frame
from gonio.protocol.generated import gonio_pb2 as pb
from gonio.protocol.generated import records

FOLDER = Path(__file__).resolve().parents[3] / "protocol" / "vectors"
BLOCKS = {
    "SAMPLES": (sample_block, "samples"),
    "POSES": (pose_block, "poses"),
    "KNOTS": (knot_block, "knots"),
}
MESSAGES = {"HELLO": pb.Hello, "REQUEST": pb.Request, "REPLY": pb.Reply, "EVENT": pb.Event}
HEXADECIMAL = ("schema_hash", "session_id")


def vectors(name: str) -> list[Any]:
    rows = tomllib.loads((FOLDER / name).read_text())["vector"]
    return [pytest.param(row, id=row["name"]) for row in rows]


def raw(vector: dict[str, Any]) -> bytes:
    return bytes.fromhex(vector["hex"])


@pytest.mark.parametrize("vector", vectors("frames.toml"))
def test_frame_is_read_and_written(vector: dict[str, Any]) -> None:
    frames = FrameDecoder().feed(raw(vector))
    assert len(frames) == 1
    frame = frames[0]
    assert frame.kind == getattr(records, f"FRAME_{vector['kind']}")
    assert (frame.sequence, frame.acknowledged) == (vector["sequence"], vector["acknowledged"])
    again = encode_frame(frame.kind, frame.sequence, frame.acknowledged, bytes(frame.payload))
    assert again == raw(vector)


@pytest.mark.parametrize("vector", [v for v in vectors("frames.toml") if v.values[0]["kind"] in MESSAGES])
def test_message_means_what_it_says(vector: dict[str, Any]) -> None:
    payload = bytes(FrameDecoder().feed(raw(vector))[0].payload)
    message = MESSAGES[vector["kind"]].FromString(payload)
    body = message
    if "body" in message.DESCRIPTOR.oneofs_by_name and (name := message.WhichOneof("body")):
        body = getattr(message, name)
    for key, wanted in vector["fields"].items():
        if key == "body":
            assert message.WhichOneof("body") == wanted
            continue
        holder = message if key in message.DESCRIPTOR.fields_by_name else body
        value = getattr(holder, key)
        if key in HEXADECIMAL:
            wanted = int(wanted, 16)  # noqa: PLW2901 - TOML has no unsigned 64-bit integers
        assert (list(value) if isinstance(wanted, list) else value) == wanted, key


@pytest.mark.parametrize("vector", [v for v in vectors("frames.toml") if v.values[0]["kind"] in BLOCKS])
def test_block_means_what_it_says(vector: dict[str, Any]) -> None:
    split, name = BLOCKS[vector["kind"]]
    header, rows = split(FrameDecoder().feed(raw(vector))[0].payload)
    fields = dict(vector["fields"])
    wanted_rows = fields.pop(name)
    assert {key: header[key].item() for key in fields} == fields
    assert len(rows) == len(wanted_rows)
    for row, wanted in zip(rows, wanted_rows, strict=True):
        assert {key: row[key].tolist() for key in wanted} == wanted


def test_knots_are_written_as_in_the_vector() -> None:
    vector = next(v.values[0] for v in vectors("frames.toml") if v.values[0]["kind"] == "KNOTS")
    fields = vector["fields"]
    knots = np.zeros(len(fields["knots"]), records.KNOT_DTYPE)
    for row, wanted in zip(knots, fields["knots"], strict=True):
        for key, value in wanted.items():
            row[key] = value
    payload = knot_payload(fields["path_id"], fields["first_knot"], knots)
    assert encode_frame(records.FRAME_KNOTS, vector["sequence"], vector["acknowledged"], payload) == raw(vector)


@pytest.mark.parametrize("vector", vectors("refused_frames.toml"))
def test_what_is_no_frame_is_refused_for_the_same_reason(vector: dict[str, Any]) -> None:
    with pytest.raises(FrameError) as caught:
        FrameDecoder().feed(raw(vector))
    assert caught.value.problem.value == vector["refusal"]
