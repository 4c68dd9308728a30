"""fuzz_xml.py: any bytes as a BSDF XML file end in findings or in one UsageError, never in another exception."""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["gonio"]):
    from inputs import changed, one_line

    from gonio.formats.window import read as window_reader

SEED = (
    b'<?xml version="1.0"?><WindowElement xmlns="http://windows.lbl.gov"><Optical><Layer><Material><Name>a</Name>'
    b"</Material><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis><AngleBasisName>"
    b"LBNL/Klems Full</AngleBasisName></AngleBasis></DataDefinition><WavelengthData><Wavelength>Visible</Wavelength>"
    b"<WavelengthDataBlock><WavelengthDataDirection>Transmission Front</WavelengthDataDirection><ScatteringData>1, 2"
    b"</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"
)
FILE = Path(tempfile.mkdtemp(prefix="gonio-fuzz-")) / "bsdf.xml"


def one_input(data: bytes) -> None:
    FILE.write_bytes(changed(data, (SEED,)))
    with one_line():
        window_reader.read(FILE)


if __name__ == "__main__":
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
