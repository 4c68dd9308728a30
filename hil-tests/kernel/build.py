"""build.py: the virtual machine's kernel, built once from Debian's source and kept under a hash of its inputs."""

import fcntl
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).resolve().parent
SOURCE_PACKAGE = "linux-source-6.1"
PACKAGES = (
    SOURCE_PACKAGE,
    "flex",
    "bison",
    "bc",
    "libelf-dev",
    "libssl-dev",
    "xz-utils",
    "kmod",
    "cpio",
    "gcc",
    "make",
)
DRIVER_FOLDER = Path("drivers/net/can")
BUILD_TIMEOUT_S = 3600.0  # ten minutes on two cores; a busy machine takes longer


class KernelError(Exception):
    """The kernel cannot be had; the text says what to do."""


@dataclass(frozen=True)
class Inputs:
    """All that the kernel depends on."""

    config: bytes
    driver: bytes
    source_version: str
    compiler: str

    def digest(self) -> str:
        """Sixteen hexadecimal digits; each input is framed by its length, so that none can run into the next."""
        parts = (self.config, self.driver, self.source_version.encode(), self.compiler.encode())
        whole = hashlib.sha256()
        for part in parts:
            whole.update(len(part).to_bytes(8, "little") + part)
        return whole.hexdigest()[:16]


def read_inputs() -> Inputs:
    """The inputs of this machine. Raises KernelError if the kernel's source or the compiler is not installed."""
    version = _output("dpkg-query", "-W", "-f", "${Version}", SOURCE_PACKAGE)
    compiler = _output("gcc", "--version").splitlines()[:1]
    if not version or not compiler:
        raise KernelError(f"the virtual machine's kernel cannot be built: apt install {' '.join(PACKAGES)}")
    return Inputs(
        config=(HERE / "kernel.config").read_bytes(),
        driver=(HERE / "gonio_can_sim.c").read_bytes(),
        source_version=version,
        compiler=compiler[0],
    )


def cache_root() -> Path:
    """Where built kernels are kept, outside the source tree: `make clean` must not cost ten minutes."""
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "gonio"


def kernel_image(say: Callable[[str], None] | None = None) -> Path:
    """The bzImage; built first if this machine has none of these inputs. Another process that builds is waited for."""
    inputs = read_inputs()
    folder = cache_root() / f"kernel-{inputs.digest()}"
    image = folder / "bzImage"
    if image.is_file():
        return image
    folder.mkdir(parents=True, exist_ok=True)
    with _locked(folder / "lock"):
        if not image.is_file():
            (say or print_line)(f"building the virtual machine's kernel, once, about ten minutes: log in {folder}")
            _build(inputs, folder, image)
    return image


def print_line(line: str) -> None:
    """To standard error."""
    print(line, file=sys.stderr, flush=True)  # noqa: T201 - ten silent minutes look like a fault


def _build(inputs: Inputs, folder: Path, image: Path) -> None:
    with tempfile.TemporaryDirectory(prefix="gonio-kernel-") as temporary, (folder / "build.log").open("wb") as log:
        tree = Path(temporary) / SOURCE_PACKAGE

        def run(*command: str, cwd: Path = tree) -> None:
            try:
                done = subprocess.run(
                    command,
                    cwd=cwd,
                    stdin=subprocess.DEVNULL,
                    stdout=log,
                    stderr=log,
                    timeout=BUILD_TIMEOUT_S,
                    check=False,
                ).returncode
            except OSError as error:
                raise KernelError(f"{command[0]}: {error.strerror}; apt install {' '.join(PACKAGES)}") from error
            except subprocess.TimeoutExpired as error:
                raise KernelError(f"the kernel's build hangs; see {log.name}") from error
            if done:
                raise KernelError(
                    f"the kernel's build failed at {command[0]}; see {log.name}, or: apt install {' '.join(PACKAGES)}"
                )

        run("tar", "--extract", "--file", f"/usr/src/{SOURCE_PACKAGE}.tar.xz", cwd=Path(temporary))
        add_driver(tree, inputs.driver)
        (tree / "gonio.config").write_bytes(inputs.config)
        make = ("make", f"-j{os.cpu_count() or 1}", *compilers())
        run(*make, "tinyconfig")
        run("scripts/kconfig/merge_config.sh", "-m", ".config", "gonio.config")
        run(*make, "olddefconfig")
        check_config(inputs.config.decode(), (tree / ".config").read_text())
        run(*make, "bzImage")
        partial = folder / "bzImage.partial"
        shutil.copyfile(tree / "arch/x86/boot/bzImage", partial)
        partial.rename(image)  # whole or not at all


def add_driver(tree: Path, driver: bytes) -> None:
    """Our simulated CAN interfaces, built in."""
    (tree / DRIVER_FOLDER / "gonio_can_sim.c").write_bytes(driver)
    with (tree / DRIVER_FOLDER / "Makefile").open("a") as makefile:
        makefile.write("obj-y += gonio_can_sim.o\n")


def check_config(wanted: str, got: str) -> None:
    """An option that the kernel silently dropped would look like a fault of the firmware later."""
    lines = set(got.splitlines())
    missing = [line for line in wanted.splitlines() if line.startswith("CONFIG_") and line not in lines]
    if missing:
        raise KernelError(f"kernel.config: the kernel does not take {', '.join(missing)}")


def compilers() -> Sequence[str]:
    """ccache in front of the compiler, where it is installed."""
    return ("CC=ccache gcc", "HOSTCC=ccache gcc") if shutil.which("ccache") else ()


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    with path.open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _output(*command: str) -> str:
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def main() -> int:
    """Build, print where it is."""
    try:
        image = kernel_image()
    except KernelError as error:
        print_line(f"kernel: {error}")
        return 1
    print(image)  # noqa: T201 - the answer
    return 0


if __name__ == "__main__":
    sys.exit(main())
