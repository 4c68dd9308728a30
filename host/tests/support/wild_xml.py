"""wild_xml.py: WINDOW XML with Klems matrices written by hand, tidy or as untidy as a test asks for."""

from collections.abc import Mapping

from gonio.dataset.scattering import FloatArray
from gonio.formats.window.klems import BASES, KlemsBasis

SMALL = BASES["klems-quarter"]  # quick to write and to read


def klems_xml(
    matrices: Mapping[tuple[str, str, str], FloatArray],
    basis: KlemsBasis = SMALL,
    *,
    comments: str = "",
    separator: str = ", ",
    line_end: str = "\n",
    defined: bool = True,
    basis_name: str | None = None,
    thickness: str = '<Thickness unit="Millimeter">2</Thickness>',
    structure: str = "Columns",
    label: str = "{process} {side}",
    digits: int = 9,
) -> str:
    """Keys of `matrices`: Wavelength, process, side. `defined`: with the rings of the basis, else its name only."""
    name = basis_name or basis.name
    rings = "".join(
        f"<AngleBasisBlock><Theta>{r.nominal_theta_deg:g}</Theta><ThetaBounds><LowerTheta>{r.lower_deg:g}</LowerTheta>"
        f"<UpperTheta>{r.upper_deg:g}</UpperTheta></ThetaBounds><nPhis>{r.patches}</nPhis></AngleBasisBlock>"
        for r in basis.rings
    )
    definition = f"<AngleBasis><AngleBasisName>{name}</AngleBasisName>{rings}</AngleBasis>" if defined else ""
    blocks = "".join(
        f'<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit="Integral">{band}</Wavelength>'
        f"<WavelengthDataBlock><WavelengthDataDirection>{label.format(process=process, side=side)}"
        f"</WavelengthDataDirection><ColumnAngleBasis>{name}</ColumnAngleBasis><RowAngleBasis>{name}</RowAngleBasis>"
        f"<ScatteringDataType>BTDF</ScatteringDataType><ScatteringData>"
        + line_end.join(
            separator.join(f"{value:.{digits}g}" for value in row) + separator.rstrip(" ") for row in values
        )
        + "</ScatteringData></WavelengthDataBlock></WavelengthData>\n"
        for (band, process, side), values in matrices.items()
    )
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<WindowElement xmlns="http://windows.lbl.gov"><WindowElementType>System'
        "</WindowElementType><FileType>BSDF</FileType><Optical><Layer><Material><Name>wild</Name><Manufacturer>nobody"
        f"</Manufacturer>{thickness}<DeviceType>Other</DeviceType><ThermalConductivity>1</ThermalConductivity>"
        "<EmissivityFront>0.9</EmissivityFront><EmissivityBack>0.9</EmissivityBack><TIR>0</TIR>"
        f"<Comments>{comments}</Comments></Material><DataDefinition><IncidentDataStructure>{structure}"
        f"</IncidentDataStructure>{definition}</DataDefinition>\n{blocks}</Layer></Optical></WindowElement>\n"
    )
