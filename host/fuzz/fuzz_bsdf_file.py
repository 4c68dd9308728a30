"""fuzz_bsdf_file.py: any bytes as Klems or tensor tree XML, validated, opened, imported: findings or one UsageError."""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["gonio"]):
    import numpy as np
    from inputs import changed, one_line

    from gonio.formats import validity
    from gonio.formats.asking import ask
    from gonio.formats.tensor import dataset as tree_dataset
    from gonio.formats.tensor.read import is_tensor, read_tensor
    from gonio.formats.validate import validate
    from gonio.formats.window import dataset as window_dataset
    from gonio.formats.window.scattering import window_bsdf

SMALL_BASIS = (
    b"<AngleBasis><AngleBasisName>two</AngleBasisName><AngleBasisBlock><Theta>0</Theta><ThetaBounds><LowerTheta>0"
    b"</LowerTheta><UpperTheta>40</UpperTheta></ThetaBounds><nPhis>1</nPhis></AngleBasisBlock><AngleBasisBlock><Theta>65"
    b"</Theta><ThetaBounds><LowerTheta>40</LowerTheta><UpperTheta>90</UpperTheta></ThetaBounds><nPhis>2</nPhis>"
    b"</AngleBasisBlock></AngleBasis>"
)


def document(structure: bytes, basis: bytes, names: bytes, values: bytes) -> bytes:
    return (
        b'<?xml version="1.0"?><WindowElement xmlns="http://windows.lbl.gov"><Optical><Layer><Material><Name>a</Name>'
        b'<Thickness unit="Meter">.001</Thickness><Comments>gonio-validity: {"front_faces": "exterior", "symmetry":'
        b' "none", "ranges": [{"channels": ["visible"], "from": "front", "to": "back", "theta_i": [0, 70], "phi_i":'
        b' [0, 360], "theta_s": [0, 89]}]}</Comments></Material><DataDefinition><IncidentDataStructure>'
        + structure
        + b"</IncidentDataStructure>"
        + basis
        + b"</DataDefinition><WavelengthData><Wavelength>Visible</Wavelength><WavelengthDataBlock>"
        b"<WavelengthDataDirection>Transmission Front</WavelengthDataDirection>"
        + names
        + b"<ScatteringDataType>BTDF</ScatteringDataType><ScatteringData>"
        + values
        + b"</ScatteringData></WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>"
    )


ROWS = b"<ColumnAngleBasis>two</ColumnAngleBasis><RowAngleBasis>two</RowAngleBasis>"
SHIRLEY = b"<AngleBasis>LBNL/Shirley-Chiu</AngleBasis>"
SEEDS = (
    document(b"Columns", SMALL_BASIS, ROWS, b".1, .2, .3, .1, 0, .2, .1, -.01, .2"),
    document(b"TensorTree3", b"", SHIRLEY, b"{{.1}{.2}{.1}{.3}{.1}{.2 .1 .3 .1 .2 .1 .2 .3}{.1}{.3}}"),
    document(b"TensorTree4", b"", SHIRLEY, b"{.1 .2 .1 .3 .1 .2 .1 .3 .1 .2 .1 .2 .3 .1 .1 .3}"),
)
FILE = Path(tempfile.mkdtemp(prefix="gonio-fuzz-")) / "bsdf.xml"
UNIT = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, -0.8], [0.0, 1.0, 0.0], [0.0, -0.6, -0.8]])


def one_input(data: bytes) -> None:
    data = changed(data, SEEDS)
    FILE.write_bytes(data)
    validity.parse(data.decode("latin-1"))
    tree = is_tensor(FILE)
    with one_line():
        for profile in ("window", "radiance"):
            validate(FILE, profile)  # type: ignore[arg-type]
    with one_line():
        bsdf, _ = (read_tensor if tree else window_bsdf)(FILE, None)
        for scattering in bsdf.channels.values():
            found = ask(scattering, UNIT, UNIT, np.array([0, 1, 1, 3]))
            if np.isinf(found.bsdf_per_sr).any():
                raise ValueError("a BSDF is a number or none")
    with one_line():
        if tree:
            tree_dataset.read_dataset(FILE, "interior", [(30.0, 40.0), (150.0, 10.0)])
        else:
            window_dataset.read_dataset(FILE)


if __name__ == "__main__":
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
