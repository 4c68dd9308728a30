"""runner.py: our first program in the virtual machine: sets the station up, runs the wanted scenarios in turn."""

import json
import os
import shutil
import sys
import time
import traceback
from pathlib import Path
from typing import Any

from guest.bench import Bench, write_json
from guest.gonio_command import preload
from guest.processes import NeverCameError, RigError
from guest.station import Station
from scenarios.registry import Scenario, load_scenarios

WORK = Path("/run/work")  # in memory: a write that waits for the 9p share would stop the whole machine


def run_scenario(scenario: Scenario, station: Station, job: dict[str, Any], results: Path) -> bool:
    """Run one scenario; false when the station must not be used any more as it is."""
    folder = WORK / scenario.name
    folder.mkdir()
    bench = Bench(station, job["rig"], Path(job["rig_folder"]), folder)
    began = time.monotonic()
    error: dict[str, str] | None = None
    print(f"runner: {scenario.name}", flush=True)  # noqa: T201 - the serial log says how far it came
    try:
        station.wire(scenario.wiring)
        scenario.steps(bench)
    except NeverCameError as failure:
        error = {"kind": "failed", "text": str(failure)}
    except (RigError, OSError) as failure:
        error = {"kind": "broken rig", "text": f"{failure}\n{traceback.format_exc()}"}
    except Exception:
        error = {"kind": "failed", "text": traceback.format_exc()}
    finally:
        bench.finish()
    result = bench.result() | {"error": error, "seconds": time.monotonic() - began}
    result["processes"] = [program.account() for program in station.programs() if program.alive()]
    result["goniod_log"] = station.goniod.errors.name
    write_json(folder / "result.json", result)
    carry_out(folder, results)
    took = f"{result['seconds']:.1f} s"
    print(f"runner: {scenario.name}: {error['kind'] if error else 'done'}, {took}", flush=True)  # noqa: T201
    return error is None and not scenario.spoils


def carry_out(folder: Path, results: Path) -> None:
    """Copy a scenario's files and the programs' logs so far to the machine outside; the result goes last."""
    for path in sorted(WORK.iterdir()):
        if path.is_file() and not path.name.startswith("candump"):
            shutil.copy(path, results)
    shutil.copytree(folder, results / folder.name, ignore=shutil.ignore_patterns("result.json"))
    shutil.copy(folder / "result.json", results / folder.name)


def main() -> int:
    """Run job.json of the results folder; done.json there says that all was run."""
    results = Path(sys.argv[1])
    job = json.loads((results / "job.json").read_text())
    os.chdir(job["root"])
    preload()
    WORK.mkdir()
    station = Station({name: Path(path) for name, path in job["programs"].items()}, Path(job["rig_folder"]), WORK)
    wanted = [scenario for scenario in load_scenarios() if scenario.name in job["scenarios"]]
    wanted.sort(key=lambda scenario: (scenario.wiring.can, scenario.wiring.twin, scenario.spoils))
    ran = []
    try:
        station.set_up()
        for scenario in wanted:
            if not run_scenario(scenario, station, job, results):
                station.end()
            ran.append(scenario.name)
    except RigError as error:
        write_json(results / "broken.json", {"text": str(error)})
        return 1
    finally:
        station.end()
        station.end_watchers()
        for path in WORK.glob("*.*"):
            if path.is_file():
                shutil.copy(path, results)
    write_json(results / "done.json", {"scenarios": ran, "uptime_s": time.monotonic()})
    return 0


if __name__ == "__main__":
    sys.exit(main())
