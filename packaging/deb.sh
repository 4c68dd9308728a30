#!/usr/bin/env bash
# deb.sh ARCH BUILD STRIP OUT: the Debian package of the goniod that BUILD holds, as OUT/goniod_VERSION_ARCH.deb. The same inputs give the
# same bytes; dates come from SOURCE_DATE_EPOCH.
set -euo pipefail
arch=$1
build=$2
strip=$3
out=$4
packaging=$(cd "$(dirname "$0")" && pwd)
version=$("$packaging/version.sh")
root=$(mktemp -d "${TMPDIR:-/tmp}/goniod-deb.XXXXXX")
trap 'rm -rf "$root"' EXIT
umask 022
chmod 755 "$root"

put() { install -D -m "$1" "$packaging/$2" "$root/$3"; }
install -d "$root/usr/sbin" "$root/DEBIAN"
"$strip" --strip-unneeded -o "$root/usr/sbin/goniod" "$build/firmware/app/goniod"
chmod 755 "$root/usr/sbin/goniod"
put 755 gadget usr/libexec/goniod/gadget
put 755 can-up usr/libexec/goniod/can-up
for unit in goniod.service goniod-gadget.service goniod-can@.service; do
    put 644 "$unit" "usr/lib/systemd/system/$unit"
done
put 644 70-goniod.rules usr/lib/udev/rules.d/70-goniod.rules
put 644 goniod.conf etc/gonio/goniod.conf
put 644 board.conf etc/gonio/board.conf
put 644 debian/copyright usr/share/doc/goniod/copyright
put 644 ../docs/controller.md usr/share/doc/goniod/controller.md
put 644 70-gonio-host.rules usr/share/doc/goniod/examples/70-gonio-host.rules
install -d "$root/usr/share/man/man8"
gzip -9n < "$packaging/goniod.8" > "$root/usr/share/man/man8/goniod.8.gz"
gzip -9n < "$packaging/debian/changelog" > "$root/usr/share/doc/goniod/changelog.gz"
for script in postinst prerm postrm; do
    put 755 "debian/$script" "DEBIAN/$script"
done
printf '/etc/gonio/%s\n' board.conf goniod.conf > "$root/DEBIAN/conffiles"
depends=$("$packaging/depends.sh" "$root/usr/sbin/goniod")
size=$(find "$root" -path "$root/DEBIAN" -prune -o -type f -printf '%s\n' | awk '{ kib += int(($1 + 1023) / 1024) } END { print kib }')
cat > "$root/DEBIAN/control" << CONTROL
Package: goniod
Version: $version
Architecture: $arch
Maintainer: the gonio authors <gonio@localhost>
Installed-Size: $size
Depends: $depends, adduser, iproute2, kmod, udev
Recommends: openssh-server
Suggests: can-utils, gpiod
Section: science
Priority: optional
Description: firmware of a controller for scanning goniophotometers
 goniod drives the axes of a scanning goniophotometer over CANopen, reads its
 strobe and interlocks over GPIO and its digitiser over USB, and serves the
 measuring computer over the board's USB device port or TCP on loopback.
 .
 The package installs a systemd service that has to be enabled by hand, since
 it moves an instrument.
CONTROL
(cd "$root" && find . -path ./DEBIAN -prune -o -type f -printf '%P\0' | LC_ALL=C sort -z | xargs -0 md5sum > DEBIAN/md5sums)
find "$root" -exec touch -h -d "@$SOURCE_DATE_EPOCH" {} +
mkdir -p "$out"
dpkg-deb --root-owner-group -Zxz --build "$root" "$out/goniod_${version}_$arch.deb" > /dev/null
echo "$out/goniod_${version}_$arch.deb"
