"""fuzz_points.py: any bytes as pab text, CSV or NIST table end in a dataset or in one UsageError, nothing else."""

import sys
import tempfile
from pathlib import Path

import atheris

with atheris.instrument_imports(include=["gonio"]):
    from inputs import changed, one_line

    from gonio.formats import detect
    from gonio.formats.pab import dataset as pab_dataset
    from gonio.formats.pab import write as pab_write
    from gonio.formats.tables import csv_read
    from gonio.formats.tables import nist as nist_csv

SEEDS = (
    b'#sample_name "tile"\n#incident_angle 30 45\n#intheta 30\n#inphi 45\n#upphi 90\n#colorimetry: CIE-Y\n'
    b"#measured by hand\n#datapoints_in_file: 2\n#format: theta phi BSDF\r\n10\t20 1.5e-2\r\n170 350.25 -0.001\r\n",
    b"#incident_angle 0 0\n#format: theta phi photocurrent [A]\n1 2 3e-9\n2 3 4e-9\n5 200 1e-9\n",
    b"#intheta -15\n#inphi 0\n#colorimetry: CIE-XYZ\n#gonio_front_faces exterior\n#format: theta phi DSF\n"
    b"1 2 .3 .4 .5\n",
    b"# gonio points\n# front_faces: exterior\n# wavelength_nm: 633 red\nchannel,theta_i_deg,phi_i_deg,theta_s_deg,"
    b"phi_s_deg,dsf_per_sr,u_dsf_per_sr,u_combined_per_sr,solid_angle_sr,count,flags\n"
    b"red,0,0,20,30,.5,1e-3,2e-3,.01,4,low_signal\nred,0,0,25,30,,,,.01,4,shadowed|low_signal\n",
    b"lambda,thetai,phi,thetar,phir,f_r11\n.633,-30,0,20,180,3.1E-01\n.633,-30,0,25,-180,3.2E-01\n",
)
FOLDER = Path(tempfile.mkdtemp(prefix="gonio-fuzz-"))
FILE, OUT = FOLDER / "points", FOLDER / "again.txt"


def one_input(data: bytes) -> None:
    data = changed(data, SEEDS)
    FILE.write_bytes(data)
    for read in (detect.point_format, nist_csv.read, csv_read.read):
        with one_line():
            read(FILE)
    paths: list[Path] = []
    with one_line():
        paths = pab_write.write(pab_dataset.read([FILE]), OUT, front="interior").paths
    for path in paths:  # what our writer wrote is good
        pab_dataset.read([path])
        path.unlink()


if __name__ == "__main__":
    atheris.Setup(sys.argv, one_input)
    atheris.Fuzz()
