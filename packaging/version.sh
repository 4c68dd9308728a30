#!/bin/sh
# version.sh: the version that the firmware says of itself.
sed -n 's/.*GN_FIRMWARE_NAME "gonio firmware \([0-9.]*\)".*/\1/p' "$(dirname "$0")/../firmware/core/stream/session.h" | grep .
