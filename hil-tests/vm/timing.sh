# timing.sh: the timing lane: firmware, twin and a small host at 500 Hz, all from memory; what they say stays in /run.
# The harness puts GONIOD, TWIN, HOST, SCENARIO, SAMPLES and GONIO_SOURCE_DIR in front.
set -e
ip link add vcan0 type vcan
ip link set vcan0 up
CHIP=/sys/kernel/config/gpio-sim/instrument
mkdir -p $CHIP/bank0
echo 8 > $CHIP/bank0/num_lines
echo 1 > $CHIP/live
LINES=/sys/devices/platform/$(cat $CHIP/dev_name)/$(cat $CHIP/bank0/chip_name)
DEVICE=/dev/$(cat $CHIP/bank0/chip_name)

GADGET=/sys/kernel/config/usb_gadget/digitiser
mkdir -p $GADGET/strings/0x409 $GADGET/configs/c.1 $GADGET/functions/ffs.digitiser /run/ffs-digitiser
echo 0x1209 > $GADGET/idVendor
echo 0x0002 > $GADGET/idProduct
echo DIGI0001 > $GADGET/strings/0x409/serialnumber
ln -s $GADGET/functions/ffs.digitiser $GADGET/configs/c.1/
mount -t functionfs digitiser /run/ffs-digitiser

wait_for() { # FILE WORD
    until grep -q "$2" "$1"; do sleep 0.05; done
}

$TWIN $SCENARIO --can vcan0 --gpio-sim $LINES --digitiser /run/ffs-digitiser --control /run/twin.sock \
    --journal /run/journal.json > /run/twin.out 2> /run/twin.err &
TWIN_PID=$!
chrt -f -p 40 $TWIN_PID
wait_for /run/twin.out serving
echo dummy_udc.1 > $GADGET/UDC
cat > /run/goniod.conf << CONF
can.interface = vcan0
input.strobe = $DEVICE:0
input.door = $DEVICE:1
input.emergency_stop = $DEVICE:2
input.sto = $DEVICE:3
input.limit = $DEVICE:4
output.shutter = $DEVICE:5
output.lamp = $DEVICE:6
output.watchdog = $DEVICE:7
link.functionfs = none
link.tcp_port = 7411
CONF
$GONIOD --config /run/goniod.conf > /run/goniod.out 2> /run/goniod.err &
GONIOD_PID=$!
wait_for /run/goniod.out listening
set +e
$HOST $SCENARIO --connect 127.0.0.1:7411 --samples $SAMPLES > /run/host.json 2> /run/host.err
echo $? > /run/host.status
kill -TERM $GONIOD_PID $TWIN_PID
wait
umount /run/ffs-digitiser
