"""test_packages.py: the Debian packages that make dist left in build/dist: architecture, files, units, settings."""

import gzip
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PACKAGING = ROOT / "packaging"
DIST = ROOT / "build" / "dist"
MACHINES = {"amd64": "Advanced Micro Devices X86-64", "arm64": "AArch64", "armhf": "ARM"}
QEMU = {"arm64": "qemu-aarch64-static", "armhf": "qemu-arm-static"}
FILES = {
    "etc/gonio/board.conf",
    "etc/gonio/goniod.conf",
    "usr/lib/systemd/system/goniod.service",
    "usr/lib/systemd/system/goniod-gadget.service",
    "usr/lib/systemd/system/goniod-can@.service",
    "usr/lib/udev/rules.d/70-goniod.rules",
    "usr/libexec/goniod/can-up",
    "usr/libexec/goniod/gadget",
    "usr/sbin/goniod",
    "usr/share/doc/goniod/changelog.gz",
    "usr/share/doc/goniod/controller.md",
    "usr/share/doc/goniod/copyright",
    "usr/share/doc/goniod/examples/70-gonio-host.rules",
    "usr/share/man/man8/goniod.8.gz",
}


def said(*command: str | Path, status: int = 0, **more: object) -> str:
    """Run a program that must end with `status`; what it printed."""
    done = subprocess.run(
        [str(word) for word in command],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        **more,  # type: ignore[call-overload]
    )
    assert done.returncode == status, done.stdout + done.stderr
    return str(done.stdout)


def package(arch: str) -> Path:
    """The package of an architecture; the test is not run where it was not built."""
    if shutil.which("dpkg-deb") is None:
        pytest.skip("dpkg-deb is not there (no Debian)")
    found = sorted(DIST.glob(f"goniod_*_{arch}.deb"))
    if not found:
        pytest.skip(f"no package for {arch} in build/dist (make dist builds it)")
    assert len(found) == 1, "an old package lies beside the new one"
    return found[0]


@pytest.fixture(scope="module", params=["amd64", "arm64", "armhf"])
def unpacked(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[str, Path]:
    """Architecture, and the folder with the package's files; its control files are in DEBIAN."""
    arch: str = request.param
    folder = tmp_path_factory.mktemp(arch)
    said("dpkg-deb", "-R", package(arch), folder)
    return arch, folder


def test_files_and_architecture(unpacked: tuple[str, Path]) -> None:
    arch, folder = unpacked
    files = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file()}
    assert {name for name in files if not name.startswith("DEBIAN/")} == FILES
    header = said("readelf", "-h", folder / "usr/sbin/goniod")
    assert re.search(r"Machine:\s+" + MACHINES[arch], header)
    assert re.search(r"Type:\s+DYN", header), "position independent"
    control = said("dpkg-deb", "-f", package(arch))
    assert f"\nArchitecture: {arch}\n" in control
    (version,) = re.findall(r"^Version: (.*)$", control, re.MULTILINE)
    assert version == said(PACKAGING / "version.sh").strip()
    assert gzip.decompress((folder / "usr/share/doc/goniod/changelog.gz").read_bytes()).startswith(
        f"goniod ({version}) ".encode()
    )
    assert said("md5sum", "--check", "--quiet", "DEBIAN/md5sums", cwd=folder) == ""
    assert (
        said("dpkg-deb", "-c", package(arch)).count(" root/root ")
        == len(FILES) + len([p for p in folder.rglob("*") if p.is_dir() and "DEBIAN" not in p.parts]) + 1
    ), "all belong to root"


def test_program_is_hardened(unpacked: tuple[str, Path]) -> None:
    _, folder = unpacked
    dynamic = said("readelf", "-Wdl", folder / "usr/sbin/goniod")
    assert "BIND_NOW" in dynamic
    assert "GNU_RELRO" in dynamic
    assert "RPATH" not in dynamic
    assert "RUNPATH" not in dynamic


def test_program_checks_itself(unpacked: tuple[str, Path]) -> None:
    """The packaged program, stripped as it is, under emulation where need be."""
    arch, folder = unpacked
    program: list[str | Path] = [folder / "usr/sbin/goniod"]
    if arch in QEMU:
        sysroot = ROOT / "build" / "cross" / arch / "sysroot"
        if shutil.which(QEMU[arch]) is None or not sysroot.exists():
            pytest.skip(f"no {QEMU[arch]} or no libraries to run it with (make cross)")
        program = [QEMU[arch], "-L", sysroot, *program]
    elif os.uname().machine != "x86_64":
        pytest.skip("this machine is no x86-64")
    assert "FAILED" not in said(*program, "--self-test")
    checked = said(*program, "--check-config", "--config", folder / "etc/gonio/goniod.conf", status=1)
    assert "goniod.conf is good" in checked


def test_dependencies_agree_with_dpkg_shlibdeps(tmp_path: Path) -> None:
    """For this machine's architecture dpkg knows the packages itself."""
    if shutil.which("dpkg-shlibdeps") is None:
        pytest.skip("dpkg-shlibdeps is not there (dpkg-dev)")
    arch = said("dpkg", "--print-architecture").strip()
    said("dpkg-deb", "-R", package(arch), tmp_path / "root")
    (tmp_path / "debian").mkdir()
    (tmp_path / "debian/control").write_text("Source: goniod\n\nPackage: goniod\nArchitecture: any\n")
    theirs = said("dpkg-shlibdeps", "-O", tmp_path / "root/usr/sbin/goniod", cwd=tmp_path)
    depends = said("dpkg-deb", "-f", package(arch), "Depends").strip()
    for one in theirs.strip().removeprefix("shlibs:Depends=").split(", "):
        assert one in depends.split(", ")


def test_units_hold(unpacked: tuple[str, Path]) -> None:
    _, folder = unpacked
    if shutil.which("systemd-analyze") is None:
        pytest.skip("systemd-analyze is not there")
    units = sorted((folder / "usr/lib/systemd/system").glob("*.service"))
    assert len(units) == 3
    said("systemd-analyze", "verify", "--man=no", "--recursive-errors=no", f"--root={folder}", *(u.name for u in units))


def test_the_same_inputs_give_the_same_bytes(tmp_path: Path) -> None:
    """Another run of the packaging, whatever the clock says."""
    arch = "amd64"
    build = ROOT / "build" / "cross" / arch / "build"
    first = package(arch)
    dates = set(re.findall(r"\d{4}-\d\d-\d\d \d\d:\d\d", said("dpkg-deb", "-c", first, env=os.environ | {"TZ": "UTC"})))
    assert len(dates) == 1
    epoch = said("date", "-u", "-d", dates.pop(), "+%s").strip()
    made = []
    for name in ("a", "b"):
        out = tmp_path / name
        said(
            PACKAGING / "deb.sh", arch, build, "strip", out, env=os.environ | {"SOURCE_DATE_EPOCH": epoch, "TZ": "UTC"}
        )
        made.append((out / first.name).read_bytes())
    assert made[0] == made[1]


def test_the_source_goes_with_the_packages() -> None:
    """libgpiod is linked in: its licence asks for its source and for ours."""
    package("amd64")
    (archive,) = DIST.glob("goniod_*_source.tar.xz")
    names = {name.split("/", 1)[1] for name in said("tar", "-tJf", archive).splitlines() if "/" in name}
    assert {"libgpiod/LICENSE", "libgpiod/lib/chip.c", "libgpiod/include/gpiod.h"} <= names
    assert {"LICENSE", "Makefile", "packaging/README.md", "firmware/app/main.c", "protocol/gonio.proto"} <= names
    assert not any(name.startswith(("build/", ".venv/")) for name in names)
