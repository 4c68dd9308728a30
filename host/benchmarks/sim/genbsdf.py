"""genbsdf.py: Klems full matrices of a device by Radiance: genbsdf.py DEVICE.rad JOB.json OUT.xml (its own process)."""

import json
import sys
from pathlib import Path


def main() -> None:
    from pyradiance import genbsdf  # noqa: PLC0415  sets RAYPATH

    device, job_file, out = (Path(argument) for argument in sys.argv[1:4])
    job = json.loads(job_file.read_text())
    box = genbsdf.SamplingBox(*job["box"])
    found = genbsdf.generate_bsdf(
        device.read_bytes(),
        nsamp=job["samples"],
        nproc=job["workers"],
        dim=box,
        params=job["parameters"],
        basis=job["basis"],
        front=job["front"],
    )
    if not job["front"]:
        found.front = found.back  # the writer wants both; the caller leaves it out
    # Our reader takes WINDOW files: Visible is all that is filled.
    out.write_bytes(genbsdf.generate_xml(vis_results=found, basis=job["basis"], unit="millimeter"))


main()
