// test_bus_health.cpp: error frames as linux/can/error.h defines them, and what they mean for the bus.
#include <gtest/gtest.h>
#include <linux/can/error.h>

extern "C" {
#include "bus_health.h"
}

namespace {

can_frame error_frame(canid_t kind, int controller = 0) {
    can_frame f{};
    f.can_id = CAN_ERR_FLAG | kind;
    f.can_dlc = CAN_ERR_DLC;
    f.data[1] = static_cast<std::uint8_t>(controller);
    return f;
}

struct Health {
    gn_bus_health health{};
    std::int64_t now_ns = 1'000'000'000;
    gn_can_bus_state after(canid_t kind, int controller = 0) {
        auto const f = error_frame(kind, controller);
        gn_bus_health_on_error(&health, &f, now_ns);
        return health.state;
    }
};

TEST(Bus_health, follows_the_controllers_error_state) {
    Health h;
    EXPECT_EQ(h.after(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_WARNING), GN_CAN_ERROR_WARNING);
    EXPECT_EQ(h.after(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE), GN_CAN_ERROR_PASSIVE);
    EXPECT_EQ(h.after(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING | CAN_ERR_CRTL_RX_PASSIVE), GN_CAN_ERROR_PASSIVE);
    EXPECT_EQ(h.after(CAN_ERR_BUSERROR | CAN_ERR_PROT | CAN_ERR_ACK), GN_CAN_ERROR_PASSIVE); // says nothing of it
    EXPECT_EQ(h.after(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), GN_CAN_ERROR_ACTIVE);
    EXPECT_EQ(h.health.error_frames, 5u);
    EXPECT_EQ(h.health.bus_offs, 0u);
}

TEST(Bus_health, bus_off_lasts_until_the_restart) {
    Health h;
    EXPECT_TRUE(gn_bus_health_can_send(&h.health));
    EXPECT_EQ(h.after(CAN_ERR_BUSOFF), GN_CAN_BUS_OFF);
    EXPECT_FALSE(gn_bus_health_can_send(&h.health));
    EXPECT_EQ(h.after(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_WARNING), GN_CAN_BUS_OFF);
    EXPECT_EQ(h.after(CAN_ERR_RESTARTED), GN_CAN_ERROR_ACTIVE);
    EXPECT_TRUE(gn_bus_health_can_send(&h.health));
    EXPECT_EQ(h.after(CAN_ERR_BUSOFF), GN_CAN_BUS_OFF);
    EXPECT_EQ(h.health.bus_offs, 2u);
}

// Frames that waited in the socket when the bus went off prove nothing; later ones do.
TEST(Bus_health, frames_long_after_a_bus_off_prove_that_it_is_over) {
    Health h;
    h.after(CAN_ERR_BUSOFF);
    gn_bus_health_on_data(&h.health, h.now_ns + GN_BUS_OFF_PROOF_NS);
    EXPECT_EQ(h.health.state, GN_CAN_BUS_OFF);
    gn_bus_health_on_data(&h.health, h.now_ns + GN_BUS_OFF_PROOF_NS + 1);
    EXPECT_EQ(h.health.state, GN_CAN_ERROR_ACTIVE);
}

TEST(Bus_health, an_interface_that_comes_back_begins_anew) {
    Health h;
    h.after(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE);
    gn_bus_health_on_interface(&h.health, true); // was not away
    EXPECT_EQ(h.health.state, GN_CAN_ERROR_PASSIVE);
    gn_bus_health_on_interface(&h.health, false);
    EXPECT_EQ(h.health.state, GN_CAN_DOWN);
    EXPECT_FALSE(gn_bus_health_can_send(&h.health));
    EXPECT_EQ(h.after(CAN_ERR_CRTL, CAN_ERR_CRTL_ACTIVE), GN_CAN_DOWN); // older than its going
    EXPECT_EQ(h.after(CAN_ERR_BUSOFF), GN_CAN_DOWN);
    gn_bus_health_on_interface(&h.health, true);
    EXPECT_EQ(h.health.state, GN_CAN_ERROR_ACTIVE);
}

TEST(Bus_health, the_chips_own_losses_count) {
    Health h;
    EXPECT_EQ(h.after(CAN_ERR_CRTL, CAN_ERR_CRTL_RX_OVERFLOW), GN_CAN_ERROR_ACTIVE);
    EXPECT_EQ(h.health.chip_overflows, 1u);
    auto f = error_frame(CAN_ERR_CRTL, CAN_ERR_CRTL_TX_PASSIVE);
    f.can_dlc = 1; // without the byte that would say so
    gn_bus_health_on_error(&h.health, &f, 0);
    EXPECT_EQ(h.health.state, GN_CAN_ERROR_ACTIVE);
}

} // namespace
