// SPDX-License-Identifier: GPL-2.0 OR Apache-2.0
/* gonio_can_sim.c: two CAN interfaces on one simulated bus, cansim0 and cansim1, whose error state a test commands.
 *
 * QEMU's CAN cards know no bus errors. Here frames take their bit times, the lower identifier wins the bus, the echo
 * comes at the end of transmission, the transmit queue fills up (ENOBUFS), and a word written to
 * <debugfs>/cansimN/state (error-active, error-warning, error-passive, bus-off, error-frame) does what a controller's
 * error interrupt does in a real driver. A frame leaves only while the other side is up: else nobody acknowledges it.
 */
#include <linux/can/dev.h>
#include <linux/debugfs.h>
#include <linux/hrtimer.h>
#include <linux/module.h>
#include <linux/netdevice.h>
#include <linux/uaccess.h>

#define SIDES 2
#define CLOCK_HZ 16000000 /* 16 time quanta per bit at 1 Mbit/s */

struct sim_bus;

struct sim_side {
	struct can_priv can; /* first, as can_dev wants it */
	struct net_device *dev;
	struct sim_bus *bus;
	struct can_frame waiting;
	bool has_frame;
	struct can_berr_counter errors;
};

static struct sim_bus {
	spinlock_t lock; /* everything below, and each side's frame */
	struct sim_side *side[SIDES];
	struct sim_side *sending;
	struct hrtimer end_of_frame;
} the_bus;

static const struct can_bittiming_const sim_bit_times = {
	.name = "gonio_can_sim",
	.tseg1_min = 1,
	.tseg1_max = 16,
	.tseg2_min = 1,
	.tseg2_max = 8,
	.sjw_max = 4,
	.brp_min = 1,
	.brp_max = 64,
	.brp_inc = 1,
};

static bool on_bus(const struct sim_side *side)
{
	return netif_running(side->dev) && side->can.state < CAN_STATE_BUS_OFF;
}

/* Bits on the wire with the most stuffing and the space between frames. */
static u32 frame_bits(const struct can_frame *frame)
{
	u32 data = frame->can_id & CAN_RTR_FLAG ? 0 : 8 * frame->len;
	u32 stuffed = (frame->can_id & CAN_EFF_FLAG ? 54 : 34) + data;
	u32 unstuffed = 13;

	return stuffed + (stuffed - 1) / 4 + unstuffed;
}

/* The lower identifier wins; both sides must be on the bus. */
static void begin_next_frame(struct sim_bus *bus)
{
	struct sim_side *winner = NULL;
	u64 bits;
	int i;

	if (bus->sending || !on_bus(bus->side[0]) || !on_bus(bus->side[1]))
		return;
	for (i = 0; i < SIDES; i++) {
		struct sim_side *side = bus->side[i];

		if (side->has_frame && (!winner || (side->waiting.can_id & CAN_EFF_MASK) <
						   (winner->waiting.can_id & CAN_EFF_MASK)))
			winner = side;
	}
	if (!winner)
		return;
	bus->sending = winner;
	bits = frame_bits(&winner->waiting);
	hrtimer_start(&bus->end_of_frame,
		      ns_to_ktime(div_u64(bits * NSEC_PER_SEC, winner->can.bittiming.bitrate)),
		      HRTIMER_MODE_REL_SOFT);
}

static void deliver(struct sim_side *to, const struct can_frame *frame)
{
	struct can_frame *copy;
	struct sk_buff *skb = alloc_can_skb(to->dev, &copy);

	if (!skb) {
		to->dev->stats.rx_dropped++;
		return;
	}
	copy->can_id = frame->can_id;
	copy->len = frame->len;
	if (!(frame->can_id & CAN_RTR_FLAG)) {
		memcpy(copy->data, frame->data, frame->len);
		to->dev->stats.rx_bytes += frame->len;
	}
	to->dev->stats.rx_packets++;
	netif_rx(skb);
}

static enum hrtimer_restart frame_ends(struct hrtimer *timer)
{
	struct sim_bus *bus = container_of(timer, struct sim_bus, end_of_frame);
	struct sim_side *from;

	spin_lock(&bus->lock);
	from = bus->sending;
	bus->sending = NULL;
	if (from && from->has_frame && on_bus(from)) {
		struct sim_side *to = bus->side[from == bus->side[0]];

		if (on_bus(to)) {
			deliver(to, &from->waiting);
			from->has_frame = false;
			from->dev->stats.tx_packets++;
			from->dev->stats.tx_bytes += can_get_echo_skb(from->dev, 0, NULL);
			netif_wake_queue(from->dev);
		}
	}
	begin_next_frame(bus);
	spin_unlock(&bus->lock);
	return HRTIMER_NORESTART;
}

static netdev_tx_t sim_xmit(struct sk_buff *skb, struct net_device *dev)
{
	struct sim_side *side = netdev_priv(dev);

	if (can_dev_dropped_skb(dev, skb))
		return NETDEV_TX_OK;
	spin_lock_bh(&side->bus->lock);
	netif_stop_queue(dev);
	memcpy(&side->waiting, skb->data, sizeof(side->waiting));
	can_put_echo_skb(skb, dev, 0, 0);
	side->has_frame = true;
	begin_next_frame(side->bus);
	spin_unlock_bh(&side->bus->lock);
	return NETDEV_TX_OK;
}

/* With the lock held: error counters at zero, nothing waits. */
static void start_side(struct sim_side *side)
{
	side->has_frame = false;
	side->errors.txerr = 0;
	side->errors.rxerr = 0;
	side->can.state = CAN_STATE_ERROR_ACTIVE;
}

static int sim_open(struct net_device *dev)
{
	struct sim_side *side = netdev_priv(dev);
	int error = open_candev(dev);

	if (error)
		return error;
	spin_lock_bh(&side->bus->lock);
	start_side(side);
	begin_next_frame(side->bus);
	spin_unlock_bh(&side->bus->lock);
	netif_start_queue(dev);
	return 0;
}

static int sim_stop(struct net_device *dev)
{
	struct sim_side *side = netdev_priv(dev);

	netif_stop_queue(dev);
	spin_lock_bh(&side->bus->lock);
	side->has_frame = false;
	side->can.state = CAN_STATE_STOPPED;
	spin_unlock_bh(&side->bus->lock);
	close_candev(dev);
	return 0;
}

/* The restart after bus-off: can_dev has thrown away what waited. */
static int sim_set_mode(struct net_device *dev, enum can_mode mode)
{
	struct sim_side *side = netdev_priv(dev);

	if (mode != CAN_MODE_START)
		return -EOPNOTSUPP;
	spin_lock_bh(&side->bus->lock);
	start_side(side);
	begin_next_frame(side->bus);
	spin_unlock_bh(&side->bus->lock);
	netif_wake_queue(dev);
	return 0;
}

static int sim_get_errors(const struct net_device *dev, struct can_berr_counter *errors)
{
	const struct sim_side *side = netdev_priv(dev);

	*errors = side->errors;
	return 0;
}

/* What a real driver does in its error interrupt. The transmit counter is the first that the standard gives the state. */
static int change_state(struct sim_side *side, enum can_state state)
{
	static const u16 least_errors[] = { 0, 96, 128, 256 };
	struct net_device *dev = side->dev;
	struct can_frame *frame;
	struct sk_buff *skb;

	if (!netif_running(dev))
		return -ENETDOWN;
	if (side->can.state == CAN_STATE_BUS_OFF)
		return -EBUSY; /* left by a restart only */
	if (side->can.state == state)
		return 0;
	skb = alloc_can_err_skb(dev, &frame);
	spin_lock_bh(&side->bus->lock);
	side->errors.txerr = least_errors[state];
	can_change_state(dev, skb ? frame : NULL, state, CAN_STATE_ERROR_ACTIVE);
	spin_unlock_bh(&side->bus->lock);
	if (skb && state != CAN_STATE_BUS_OFF) {
		frame->can_id |= CAN_ERR_CNT;
		frame->data[6] = side->errors.txerr;
		frame->data[7] = side->errors.rxerr;
	}
	if (state == CAN_STATE_BUS_OFF)
		can_bus_off(dev);
	if (skb)
		netif_rx(skb);
	return 0;
}

/* A frame that a bus error destroyed, as with berr-reporting. */
static int report_bus_error(struct sim_side *side)
{
	struct can_frame *frame;
	struct sk_buff *skb;

	if (!on_bus(side))
		return -ENETDOWN;
	side->can.can_stats.bus_error++;
	skb = alloc_can_err_skb(side->dev, &frame);
	if (!skb)
		return -ENOMEM;
	frame->can_id |= CAN_ERR_PROT | CAN_ERR_BUSERROR;
	frame->data[2] = CAN_ERR_PROT_STUFF;
	netif_rx(skb);
	return 0;
}

static ssize_t command_write(struct file *file, const char __user *from, size_t count, loff_t *position)
{
	static const char *const states[] = { "error-active", "error-warning", "error-passive", "bus-off" };
	struct sim_side *side = file->private_data;
	char word[16] = { 0 };
	int error;

	if (count >= sizeof(word))
		return -EINVAL;
	if (copy_from_user(word, from, count))
		return -EFAULT;
	strim(word);
	if (!strcmp(word, "error-frame")) {
		error = report_bus_error(side);
	} else {
		int state = match_string(states, ARRAY_SIZE(states), word);

		error = state < 0 ? -EINVAL : change_state(side, state);
	}
	return error ? error : count;
}

static const struct file_operations command_operations = {
	.open = simple_open,
	.write = command_write,
	.llseek = noop_llseek,
};

static const struct net_device_ops sim_operations = {
	.ndo_open = sim_open,
	.ndo_stop = sim_stop,
	.ndo_start_xmit = sim_xmit,
	.ndo_change_mtu = can_change_mtu,
};

static int __init make_side(struct sim_bus *bus, int i)
{
	struct net_device *dev = alloc_candev(sizeof(struct sim_side), 1);
	struct sim_side *side;

	if (!dev)
		return -ENOMEM;
	side = netdev_priv(dev);
	side->dev = dev;
	side->bus = bus;
	side->can.clock.freq = CLOCK_HZ;
	side->can.bittiming_const = &sim_bit_times;
	side->can.do_set_mode = sim_set_mode;
	side->can.do_get_berr_counter = sim_get_errors;
	dev->netdev_ops = &sim_operations;
	dev->flags |= IFF_ECHO;
	snprintf(dev->name, sizeof(dev->name), "cansim%d", i);
	bus->side[i] = side;
	return register_candev(dev);
}

/* Built in, never unloaded: nothing is torn down. */
static int __init sim_init(void)
{
	int i;

	spin_lock_init(&the_bus.lock);
	hrtimer_init(&the_bus.end_of_frame, CLOCK_MONOTONIC, HRTIMER_MODE_REL_SOFT);
	the_bus.end_of_frame.function = frame_ends;
	for (i = 0; i < SIDES; i++) {
		int error = make_side(&the_bus, i);

		if (error)
			return error;
	}
	for (i = 0; i < SIDES; i++)
		debugfs_create_file("state", 0200, debugfs_create_dir(the_bus.side[i]->dev->name, NULL),
				    the_bus.side[i], &command_operations);
	return 0;
}
device_initcall(sim_init);

MODULE_DESCRIPTION("A pair of simulated CAN interfaces with commanded error states");
MODULE_LICENSE("GPL");
