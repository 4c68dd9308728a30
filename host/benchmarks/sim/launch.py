"""launch.py: starts a program from a small process and writes what it took: launch.py REPORT COMMAND...

A child's peak memory counts its parent's before it became the program: so the parent must be small.
"""

import json
import os
import sys
import time


def main() -> None:
    start = time.perf_counter()
    child = os.fork()
    if child == 0:
        os.execvp(sys.argv[2], sys.argv[2:])
    _, status, usage = os.wait4(child, 0)
    report = {
        "exit": os.waitstatus_to_exitcode(status),
        "wall_s": time.perf_counter() - start,
        "cpu_s": usage.ru_utime + usage.ru_stime,
        "peak_mib": usage.ru_maxrss / 1024,
    }
    with open(sys.argv[1], "w", encoding="ascii") as file:
        json.dump(report, file)


main()
