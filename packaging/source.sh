#!/usr/bin/env bash
# source.sh GPIOD OUT: the source that belongs to the packages, as OUT/goniod_VERSION_source.tar.xz: this tree and libgpiod's (which goniod
# holds a copy of: its licence asks for both).
set -euo pipefail
gpiod=$1
out=$2
root=$(cd "$(dirname "$0")/.." && pwd)
name=goniod-$("$root/packaging/version.sh")
stage=$(mktemp -d "${TMPDIR:-/tmp}/goniod-source.XXXXXX")
trap 'rm -rf "$stage"' EXIT
mkdir -p "$stage/$name/libgpiod" "$out"
(cd "$root" && git ls-files -zco --exclude-standard | while IFS= read -r -d '' file; do [ ! -e "$file" ] || printf '%s\0' "$file"; done) |
    tar -C "$root" --null -T - -cf - | tar -C "$stage/$name" -xf -
cp -r "$gpiod/lib" "$gpiod/include" "$gpiod/LICENSE" "$gpiod/libgpiod-version.txt" "$stage/$name/libgpiod/"
archive=$out/goniod_${name#goniod-}_source.tar.xz
tar -C "$stage" --sort=name --mtime="@$SOURCE_DATE_EPOCH" --owner=0 --group=0 --numeric-owner --mode=u=rwX,go=rX -cf - "$name" | xz -T1 -6 > "$archive"
echo "$archive"
