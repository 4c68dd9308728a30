#!/bin/busybox sh
# init.sh: first program of the virtual machine: mounts, then runs start.sh of the results folder, then ends the machine.
# lane=system: on the host's own root, read-only by 9p; only /run can be written. lane=timing: all from memory.
export PATH=/bin:/sbin:/usr/bin:/usr/sbin
/bin/busybox mkdir -p /bin /sbin /etc
/bin/busybox --install -s /bin
mount -t proc proc /proc
mount -t devtmpfs dev /dev
mkdir -p /dev/pts /dev/shm
mount -t devpts pts /dev/pts
echo "init: kernel is up after $(cut -d' ' -f1 /proc/uptime) s"

share() { # TAG DIRECTORY OPTIONS
    mount -t 9p -o "trans=virtio,version=9p2000.L,msize=262144,$3" "$1" "$2" || echo "init: cannot mount $1"
}

kernel_files() { # ROOT
    mount -t sysfs sysfs "$1/sys"
    mount -t configfs configfs "$1/sys/kernel/config"
    mount -t debugfs debugfs "$1/sys/kernel/debug"
}

ip link set lo up
if grep -q lane=timing /proc/cmdline; then
    kernel_files ""
    mount -t tmpfs tmpfs /run
    sh /start.sh > /run/log 2>&1
    echo "init: start.sh ended with $?"
    mkdir -p /results
    share results /results cache=none # only now: waiting on 9p makes guest time run away
    cp -r /run/* /results/
else
    share host /host ro,cache=loose
    mount -t proc proc /host/proc
    mount --bind /dev /host/dev
    mount --bind /dev/pts /host/dev/pts
    mount -t tmpfs tmpfs /host/dev/shm
    mount -t tmpfs tmpfs /host/run
    kernel_files /host
    mkdir -p /host/run/results /host/run/tmp /host/run/user
    share results /host/run/results cache=none
    chroot /host /bin/sh /run/results/start.sh
    echo "init: start.sh ended with $?"
fi
sync
echo "init: end after $(cut -d' ' -f1 /proc/uptime) s"
reboot -f
