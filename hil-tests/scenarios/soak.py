"""soak.py: many scans one after the other, with the memory of firmware and twin after each."""

from guest.bench import Bench
from scenarios.registry import scenario


@scenario()
def soak(bench: Bench) -> None:
    programs = {"goniod": bench.station.goniod, "twin": bench.station.twin_program}
    resident_kib: dict[str, list[float | str]] = {name: [] for name in programs}
    bench.values["resident_kib"] = resident_kib
    for number in range(1, bench.rig["vm"]["soak_scans"] + 1):
        bench.end(bench.scan("short.toml", f"scan-{number:03d}.mcap"))
        bench.until_safe()
        for name, program in programs.items():
            resident_kib[name].append(program.account()["resident_kib"])
