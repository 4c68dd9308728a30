"""throughput.py: 100,000 samples per second through the emulated USB, from a digitiser that counts them."""

from guest.bench import Bench
from scenarios.registry import scenario


@scenario(twin="twin-fast.toml")
def throughput(bench: Bench) -> None:
    """Over USB all the way: digitiser to firmware, firmware to host."""
    bench.end(bench.scan("fast.toml", device=bench.usb))
    bench.until_safe()
