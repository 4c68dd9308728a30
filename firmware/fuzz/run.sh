#!/usr/bin/env bash
# run.sh LOGS OPTIONS... -- TARGETS...: run fuzz targets (libFuzzer programs, atheris scripts) with libFuzzer options; a finding ends it with its input named.
set -euo pipefail
logs=$1
shift
options=()
while [ "$#" -gt 0 ] && [ "$1" != -- ]; do
    options+=("$1")
    shift
done
shift
mkdir -p "$logs/tmp"
export TMPDIR=$logs/tmp
found=0
for target in "$@"; do
    [ -x "$target" ] || [[ $target == *.py ]] || continue
    [ -f "$target" ] || continue
    found=$((found + 1))
    name=$(basename "$target")
    log=$logs/$name.log
    command=("$target")
    [[ $target == *.py ]] && command=("${PYTHON:-python3}" "$target")
    if ! "${command[@]}" "${options[@]}" -artifact_prefix="$logs/$name." >"$log" 2>&1; then
        tail -n 25 "$log" >&2
        echo "fuzzing: $name has a finding; its input is beside $log" >&2
        exit 1
    fi
    printf '%-28s %s\n' "$name" "$(grep -E '^Done|DONE' "$log" | tail -n 1)"
done
[ "$found" -gt 0 ] || { echo "fuzzing: no targets among $*" >&2; exit 1; }
