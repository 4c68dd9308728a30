#!/usr/bin/env bash
# demo.sh: the whole chain on a simulated sample, then the same steps on NIST's measured PTFE. `make demo` runs it.
set -euo pipefail
cd "$(dirname "$0")/../.."
out=${1:-build/demo}
gonio=.venv/bin/gonio
scenario=sim/scenarios/demo.toml
ptfe=docs/examples/nist_ptfe/PTFE.data.csv
rm -rf "$out"
mkdir -p "$out"

say() { printf '\n\033[1m%s\033[0m\n' "$*"; }
run() { printf '$ %s\n' "$*" && "$@"; }

say 'Measure: firmware and twin in virtual time, free beam first, then three incident directions'
run $gonio scan docs/examples/demo.toml --device "twin:$scenario" -o "$out/raw.mcap"
say 'Reduce: pose of every sample, dark, gains, lamp, solid angles'
run $gonio reduce "$out/raw.mcap" -o "$out/bsdf.h5"
say 'Export for WINDOW and Radiance, and check the file'
run $gonio export "$out/bsdf.h5" --format klems-full --fill nearest --assume-flat -o "$out/bsdf.xml"
run $gonio validate "$out/bsdf.xml"
say 'Report, with the truth of the simulated sample beside the measurement'
run $gonio report "$out/bsdf.h5" --scenario "$scenario" --summary "$out/summary.json" -o "$out/report.html"
say 'Compare with that truth, at the directions that were measured'
run $gonio compare "$out/bsdf.h5" "$scenario" -o "$out/compare.html"

say 'Real data: sintered PTFE, measured by NIST'
run $gonio import "$ptfe" -o "$out/ptfe_points.h5"
run $gonio reduce "$out/ptfe_points.h5" -o "$out/ptfe.h5"
run $gonio export "$out/ptfe.h5" --format csv -o "$out/ptfe.csv"
run $gonio export "$out/ptfe.h5" --format klems-full --channel "633 nm" --front exterior --fill nearest --assume-flat -o "$out/ptfe.xml"
run $gonio validate "$out/ptfe.xml"
run $gonio report "$out/ptfe.h5" -o "$out/ptfe.html"

say "Open $out/report.html, $out/compare.html and $out/ptfe.html"
