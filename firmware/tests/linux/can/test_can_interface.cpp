// test_can_interface.cpp: interfaces as sysfs shows them.
#include <gtest/gtest.h>

#include "net_folder.hpp"

extern "C" {
#include "can_interface.h"
#include "can_socket.h"
}

namespace gonio::test {
namespace {

TEST(Can_interface, looks_at_index_type_and_flags) {
    Net_folder net;
    net.set("can0", 7, type_can, up);
    net.set("can1", 8, type_can, down);
    net.set("eth0", 2, 1, up);
    gn_can_look const can0 = gn_can_interface_look(net.path(), "can0");
    EXPECT_EQ(can0.index, 7);
    EXPECT_TRUE(can0.is_can);
    EXPECT_TRUE(can0.up);
    EXPECT_FALSE(gn_can_interface_look(net.path(), "can1").up);
    EXPECT_FALSE(gn_can_interface_look(net.path(), "eth0").is_can);
    gn_can_look const none = gn_can_interface_look(net.path(), "can2");
    EXPECT_EQ(none.index, 0);
    EXPECT_FALSE(none.up);
    EXPECT_FALSE(gn_can_interface_look(std::string(200, 'x').c_str(), "can0").up);
}

TEST(Can_interface, a_machine_s_loopback_is_there_and_no_can) {
    gn_can_look const lo = gn_can_interface_look(GN_NET_FOLDER, "lo");
    if (lo.index == 0) {
        GTEST_SKIP() << "no interface lo";
    }
    EXPECT_FALSE(lo.is_can);
    EXPECT_EQ(gn_can_interface_state(lo.index), GN_CAN_ERROR_ACTIVE); // it has none
    char error[160];
    gn_can_settings const settings = {"lo", 1.0f};
    EXPECT_EQ(gn_can_socket_open(&settings, error, sizeof error), nullptr);
    EXPECT_STREQ(error, "lo is no CAN interface: see `ip link show type can`");
}

TEST(Can_interface, an_absent_one_is_named) {
    char error[160];
    gn_can_settings const settings = {"gonio-none0", 1.0f};
    EXPECT_EQ(gn_can_socket_open(&settings, error, sizeof error), nullptr);
    EXPECT_STREQ(error, "no CAN interface gonio-none0: see `ip link` for its name, load its driver");
}

} // namespace
} // namespace gonio::test
