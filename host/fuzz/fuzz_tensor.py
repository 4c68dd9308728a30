"""fuzz_tensor.py: any bytes as a tensor tree file end in findings or in one UsageError, never in another exception."""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["gonio"]):
    import numpy as np
    from inputs import changed, one_line

    from gonio.formats.tensor.read import read_tensor

SEED = (
    b'<?xml version="1.0"?><WindowElement xmlns="http://windows.lbl.gov"><Optical><Layer><Material><Name>a</Name>'
    b'<Thickness unit="Meter">1</Thickness></Material><DataDefinition><IncidentDataStructure>TensorTree3'
    b"</IncidentDataStructure></DataDefinition><WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>"
    b"<WavelengthDataDirection>Reflection Back</WavelengthDataDirection><AngleBasis>LBNL/Shirley-Chiu</AngleBasis>"
    b"<ScatteringData>{{1}{0}{1 2 3 4 5 6 7 8}{0}{.5}{0}{2e-3}{0}}</ScatteringData></WavelengthDataBlock>"
    b"</WavelengthData></Layer></Optical></WindowElement>"
)
FILE = Path(tempfile.mkdtemp(prefix="gonio-fuzz-")) / "tree.xml"
UP = np.array([[0.3, 0.2, np.sqrt(0.87)]])


def one_input(data: bytes) -> None:
    FILE.write_bytes(changed(data, (SEED,)))
    with one_line():
        bsdf, _ = read_tensor(FILE, "interior")
        for scattering in bsdf.channels.values():
            scattering.dsf_per_sr(UP, UP)
            scattering.features(UP)


if __name__ == "__main__":
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
