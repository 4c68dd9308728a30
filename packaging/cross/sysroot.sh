#!/usr/bin/env bash
# sysroot.sh ARCH DIRECTORY: unpacks Debian's ARCH packages of the libraries that goniod and gonio-l1 link into DIRECTORY. Apt keeps its
# state there too: the machine's own architectures, package lists and installed packages stay as they are.
set -euo pipefail
arch=$1
directory=$2
packages=(libusb-1.0-0-dev libnanopb-dev libtomlplusplus-dev libgtest-dev libstdc++6) # and what they depend on
state=$directory.apt
rm -rf "$directory" "$state"
mkdir -p "$directory" "$state"/{lists/partial,cache/archives/partial}
: > "$state/status"
state=$(cd "$state" && pwd)
options=(-o "APT::Architecture=$arch" -o "APT::Architectures=$arch" -o "Dir::State=$state" -o "Dir::State::Lists=$state/lists" -o "Dir::State::status=$state/status"
    -o "Dir::Cache=$state/cache" -o APT::Sandbox::User= -o Acquire::Languages=none -o Acquire::Retries=3)
# A repository beside Debian's that does not carry this architecture is no obstacle; a missing package is.
apt-get -qq "${options[@]}" update 2> "$state/update.log" || true
apt-get -qq -y "${options[@]}" --no-install-recommends --download-only install "${packages[@]}" > "$state/download.log" 2>> "$state/update.log" || {
    tail -n 5 "$state/update.log" >&2
    echo "sysroot.sh: Debian's $arch packages (${packages[*]}) could not be had; check the network and that apt's sources carry $arch" >&2
    exit 1
}
for deb in "$state"/cache/archives/*.deb; do
    dpkg-deb -x "$deb" "$directory"
done
# Links with an absolute target would leave the sysroot.
find "$directory" -type l -lname '/*' | while read -r link; do
    ln -snf "$(realpath -m --relative-to "$(dirname "$link")" "$directory$(readlink "$link")")" "$link"
done
rm -rf "$state"
