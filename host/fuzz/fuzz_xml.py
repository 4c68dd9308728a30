"""fuzz_xml.py: any bytes as a BSDF XML file end in findings or in one UsageError, never in another exception."""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["gonio"]):
    from gonio.formats.window import write as window_xml
    from gonio.units.errors import UsageError

SEED = (
    b'<?xml version="1.0"?><WindowElement xmlns="http://windows.lbl.gov"><Optical><Layer><Material><Name>a</Name>'
    b"</Material><DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis><AngleBasisName>"
    b"LBNL/Klems Full</AngleBasisName></AngleBasis></DataDefinition><WavelengthData><Wavelength>Visible</Wavelength>"
    b"<WavelengthDataBlock><WavelengthDataDirection>Transmission Front</WavelengthDataDirection><ScatteringData>1, 2"
    b"</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"
)
FILE = Path(tempfile.mkdtemp(prefix="gonio-fuzz-")) / "bsdf.xml"


def one_input(data: bytes) -> None:
    if len(data) > 3 and data[0] >= 128:
        at = int.from_bytes(data[1:3], "little") % len(SEED)
        data = SEED[:at] + data[3:] + SEED[at + len(data) - 3 :]
    FILE.write_bytes(data)
    try:
        window_xml.read(FILE)
    except UsageError as error:
        if "\n" in str(error):
            raise ValueError("an error is one line") from error


if __name__ == "__main__":
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
