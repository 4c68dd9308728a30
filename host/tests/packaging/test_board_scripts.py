"""test_board_scripts.py: the set-up of gadget and CAN interface, with folders for configfs and noted commands."""

import os
import subprocess
from pathlib import Path

import pytest

PACKAGING = Path(__file__).resolve().parents[3] / "packaging"


class Board:
    """A PATH whose system commands only note that they were called, and a configfs of plain folders."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.notes = folder / "notes"
        self.notes.touch()
        (folder / "bin").mkdir()
        for command in ("modprobe", "mount", "umount", "ip"):
            self.fake(command, "exit 0")
        self.fake("mountpoint", '[ "$2" != "$GONIO_FUNCTIONFS" ]')  # configfs is there, FunctionFS not yet
        # A new folder of configfs comes with its groups.
        groups = " ".join(f'"$1/{group}"' for group in ("strings", "configs", "functions", "os_desc"))
        self.fake("mkdir", f'/bin/mkdir "$@" || exit 1\ncase "$1" in */usb_gadget/gonio) /bin/mkdir {groups} ;; esac')
        (folder / "configfs" / "usb_gadget").mkdir(parents=True)
        (folder / "udc" / "fe980000.usb").mkdir(parents=True)
        (folder / "machine-id").write_text("0123456789abcdef0123456789abcdef\n")
        self.gadget = folder / "configfs" / "usb_gadget" / "gonio"

    def fake(self, command: str, script: str) -> None:
        program = self.folder / "bin" / command
        program.write_text(f'#!/bin/sh\necho "{command} $*" >> "{self.notes}"\n{script}\n')
        program.chmod(0o755)

    def run(self, script: str, *arguments: str, **settings: str) -> subprocess.CompletedProcess[str]:
        environment = os.environ | settings
        environment |= {
            "PATH": f"{self.folder / 'bin'}:{os.environ['PATH']}",
            "GONIO_CONFIGFS": str(self.folder / "configfs"),
            "GONIO_FUNCTIONFS": str(self.folder / "ffs"),
            "GONIO_UDC_FOLDER": str(self.folder / "udc"),
            "GONIO_BOARD_SERIAL": str(self.folder / "serial-number"),
            "GONIO_MACHINE_ID": str(self.folder / "machine-id"),
            "GONIO_CONF": str(self.folder / "goniod.conf"),
        }
        return subprocess.run(
            [str(PACKAGING / script), *arguments], env=environment, capture_output=True, text=True, check=False
        )

    def noted(self, command: str) -> list[str]:
        return [line for line in self.notes.read_text().splitlines() if line.startswith(command + " ")]


@pytest.fixture
def board(tmp_path: Path) -> Board:
    return Board(tmp_path)


def test_gadget_is_created_once_and_bound_after_that(board: Board) -> None:
    done = board.run("gadget", "create")
    assert done.returncode == 0, done.stderr
    assert (board.gadget / "idVendor").read_text() == "0x1209"
    assert (board.gadget / "idProduct").read_text() == "0x0001"
    assert (board.gadget / "os_desc/use").read_text() == "1"
    assert (board.gadget / "os_desc/qw_sign").read_text() == "MSFT100"
    assert (board.gadget / "os_desc/c.1").resolve() == board.gadget / "configs/c.1"
    assert (board.gadget / "configs/c.1/ffs.gonio").resolve() == board.gadget / "functions/ffs.gonio"
    assert not (board.gadget / "UDC").exists(), "bound only when goniod has written its descriptors"
    (mount,) = board.noted("mount")
    assert mount.startswith("mount -t functionfs -o uid=gonio,")
    assert board.run("gadget", "create", USB_SERIAL="other").returncode == 0, "again: nothing to be done"
    assert (board.gadget / "strings/0x409/serialnumber").read_text() != "other"
    assert board.run("gadget", "bind").returncode == 0
    assert (board.gadget / "UDC").read_text() == "fe980000.usb"
    assert board.run("gadget", "unbind").returncode == 0
    assert (board.gadget / "UDC").read_text().strip() == ""
    assert board.run("gadget", "bind", USB_UDC="second.usb").returncode == 0
    assert (board.gadget / "UDC").read_text() == "second.usb"


def test_gadget_serial_number(board: Board, tmp_path: Path) -> None:
    """The setting's, else the board's, else one of this machine that does not tell its id."""
    assert board.run("gadget", "create").returncode == 0
    place = board.gadget / "strings/0x409/serialnumber"
    hashed = place.read_text()
    assert len(hashed) == 16
    assert hashed not in "0123456789abcdef0123456789abcdef"
    other = tmp_path / "other"
    other.mkdir()
    second = Board(other)
    (other / "serial-number").write_bytes(b"10000000abcd\0")
    assert second.run("gadget", "create").returncode == 0
    assert (second.gadget / "strings/0x409/serialnumber").read_text() == "10000000abcd"
    third_folder = tmp_path / "third"
    third_folder.mkdir()
    third = Board(third_folder)
    assert third.run("gadget", "create", USB_SERIAL="LAB-3", USB_VENDOR="0x16c0").returncode == 0
    assert (third.gadget / "strings/0x409/serialnumber").read_text() == "LAB-3"
    assert (third.gadget / "idVendor").read_text() == "0x16c0"


def test_gadget_without_a_device_port(board: Board) -> None:
    assert board.run("gadget", "bind").returncode == 0, "no gadget: nothing to bind"
    assert board.run("gadget", "unbind").returncode == 0
    assert board.run("gadget", "create").returncode == 0
    (board.folder / "udc" / "fe980000.usb").rmdir()
    done = board.run("gadget", "bind")
    assert done.returncode == 1
    assert "no USB device port" in done.stderr
    assert board.run("gadget", "destroy").returncode == 2


def test_can_interface_of_the_settings_is_brought_up(board: Board) -> None:
    (board.folder / "goniod.conf").write_text("# can.interface = can9\ncan.interface = can1 # the drives\n")
    assert board.run("can-up", "can0").returncode == 0
    assert board.noted("ip") == [], "another bus is left alone"
    done = board.run("can-up", "can1", CAN_RESTART_MS="200")
    assert done.returncode == 0, done.stderr
    assert board.noted("ip") == [
        "ip link set can1 down",
        "ip -details link show can1",
        "ip link set can1 type can bitrate 1000000 restart-ms 200",
        "ip link set can1 txqueuelen 64",
        "ip link set can1 up",
    ]


def test_virtual_can_interface_has_no_bit_rate(board: Board) -> None:
    (board.folder / "goniod.conf").write_text("can.interface = vcan0\n")
    board.fake("ip", "echo vcan")
    assert board.run("can-up", "vcan0").returncode == 0
    assert not [line for line in board.noted("ip") if "bitrate" in line]
    assert board.noted("ip")[-1] == "ip link set vcan0 up"
