#!/usr/bin/env bash
# depends.sh PROGRAM: the Debian packages that hold the libraries PROGRAM was linked with. dpkg-shlibdeps would need the target's package
# database; a test compares the two for this machine's architecture. An unknown library ends it.
set -euo pipefail
program=$1
libc=$(readelf -W --version-info "$program" | grep -oE 'GLIBC_[0-9]+\.[0-9]+' | sort -Vu | tail -n 1)
depends=()
for library in $(readelf -W --dynamic "$program" | sed -n 's/.*(NEEDED).*\[\(.*\)\]/\1/p' | sort); do
    case $library in
    libc.so.6) depends+=("libc6 (>= ${libc#GLIBC_})") ;;
    libm.so.6 | ld-linux*) ;; # part of libc6
    libgcc_s.so.1) depends+=("libgcc-s1") ;;
    libusb-1.0.so.0) depends+=("libusb-1.0-0 (>= 2:1.0.20)") ;;
    libgpiod.so.3) depends+=("libgpiod3 (>= 2.0)") ;;
    *)
        echo "depends.sh: no package is known for $library, which $program needs" >&2
        exit 1
        ;;
    esac
done
printf '%s' "${depends[0]}"
[ ${#depends[@]} -lt 2 ] || printf ', %s' "${depends[@]:1}"
echo
