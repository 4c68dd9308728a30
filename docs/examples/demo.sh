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
say 'Fit a model that answers between and beyond the measured directions, and say how it was chosen'
run $gonio fit "$out/bsdf.h5" -o "$out/model.h5"
say 'Ask it in an incident direction that was not measured'
run $gonio query "$out/model.h5" --incident 45,0 --outgoing 45,180
say 'Export for WINDOW (Klems matrices) and for Radiance (tensor tree and the material that uses it), and check both'
run $gonio export "$out/model.h5" --format klems-full --assume-flat -o "$out/bsdf.xml"
run $gonio validate "$out/bsdf.xml"
run $gonio export "$out/model.h5" --format tensor3 --resolution 5 --material "$out/tree.rad" -o "$out/tree.xml"
run $gonio validate "$out/tree.xml" --profile radiance
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
say 'Fit a model to it, and compare the model with the points (NIST does not declare the symmetry, the user does)'
run $gonio fit "$out/ptfe.h5" --channel "633 nm" --symmetry isotropic -o "$out/ptfe_model.h5"
run $gonio compare "$out/ptfe.h5" "$out/ptfe_model.h5"

say "Open $out/report.html, $out/compare.html and $out/ptfe.html"
