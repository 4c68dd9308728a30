"""gadgets.py: USB devices by FunctionFS on dummy_hcd, bound once their program has written its descriptors."""

from dataclasses import dataclass
from pathlib import Path

from guest.interfaces import CONFIGFS, run

RUN = Path("/run")


@dataclass(frozen=True)
class Gadget:
    """One USB device. `controller` is the device controller that it hangs on; `mount` goes to its program."""

    name: str
    product_id: int
    serial: str
    controller: str
    windows: bool  # announces Microsoft's OS descriptors

    @property
    def folder(self) -> Path:
        return CONFIGFS / "usb_gadget" / self.name

    @property
    def mount(self) -> Path:
        return RUN / f"ffs-{self.name}"

    def prepare(self) -> None:
        """All but the binding, which must wait for the descriptors."""
        strings = self.folder / "strings" / "0x409"
        strings.mkdir(parents=True)
        configuration = self.folder / "configs" / "c.1"
        configuration.mkdir()
        function = self.folder / "functions" / f"ffs.{self.name}"
        function.mkdir()
        values = {
            "idVendor": "0x1209",
            "idProduct": f"{self.product_id:#06x}",
            "bcdUSB": "0x0200",
            "bcdDevice": "0x0100",
            "strings/0x409/serialnumber": self.serial,
            "strings/0x409/manufacturer": "gonio",
            "strings/0x409/product": f"gonio {self.name}",
            "configs/c.1/MaxPower": "2",
        }
        if self.windows:
            values |= {"os_desc/use": "1", "os_desc/b_vendor_code": "0xcd", "os_desc/qw_sign": "MSFT100"}
        for key, value in values.items():
            (self.folder / key).write_text(value)
        (configuration / function.name).symlink_to(function)
        if self.windows:
            (self.folder / "os_desc" / "c.1").symlink_to(configuration)
        self.mount.mkdir()
        run("mount", "-t", "functionfs", self.name, str(self.mount))

    def bind(self) -> None:
        """Plug it in. The kernel has pulled it out by itself when its program died."""
        if self.bound_to() != self.controller:
            (self.folder / "UDC").write_text(self.controller)

    def bound_to(self) -> str:
        """The device controller that it is bound to, or nothing."""
        return (self.folder / "UDC").read_text().strip()

    def unplug(self) -> None:
        """Pull the cable; the program lives on. (soft_connect would do, but dummy_hcd does not enumerate after it.)"""
        (self.folder / "UDC").write_text("\n")

    def plug(self) -> None:
        """Put the cable back."""
        self.bind()


LINK = Gadget("gonio", 0x0001, "HIL0001", "dummy_udc.0", windows=True)
DIGITISER = Gadget("digitiser", 0x0002, "DIGI0001", "dummy_udc.1", windows=False)
