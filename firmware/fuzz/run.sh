#!/usr/bin/env bash
# run.sh: run every fuzz target of a build directory with the given libFuzzer options; a finding ends it with its input named.
set -euo pipefail
folder=$1
shift
found=0
for target in "$folder"/fuzz_*; do
    [ -x "$target" ] && [ -f "$target" ] || continue
    found=$((found + 1))
    log="$target.log"
    if ! "$target" "$@" -artifact_prefix="$target." >"$log" 2>&1; then
        tail -n 25 "$log" >&2
        echo "fuzzing: $(basename "$target") has a finding; its input is beside $log" >&2
        exit 1
    fi
    printf '%-28s %s\n' "$(basename "$target")" "$(grep -E '^Done|DONE' "$log" | tail -n 1)"
done
[ "$found" -gt 0 ] || { echo "fuzzing: no targets in $folder" >&2; exit 1; }
