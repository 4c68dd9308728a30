// usb_descriptors.hpp: what FunctionFS is told of the digitiser: one vendor interface, one bulk IN endpoint, full and
// high speed.
#pragma once

#include <array>
#include <cstdint>

#include <linux/usb/ch9.h>
#include <linux/usb/functionfs.h>

namespace gonio::sim {

struct __attribute__((packed)) Digitiser_interface {
    usb_interface_descriptor interface;
    usb_endpoint_descriptor_no_audio bulk_in;
};

struct __attribute__((packed)) Digitiser_descriptors {
    usb_functionfs_descs_head_v2 head;
    std::uint32_t full_speed_count;
    std::uint32_t high_speed_count;
    Digitiser_interface full_speed;
    Digitiser_interface high_speed;
};

struct __attribute__((packed)) Digitiser_strings {
    usb_functionfs_strings_head head;
    std::uint16_t language;
    std::array<char, 16> name;
};

constexpr Digitiser_interface digitiser_interface(std::uint16_t packet_bytes) {
    return {{.bLength = sizeof(usb_interface_descriptor),
             .bDescriptorType = USB_DT_INTERFACE,
             .bInterfaceNumber = 0,
             .bAlternateSetting = 0,
             .bNumEndpoints = 1,
             .bInterfaceClass = 0xFF,
             .bInterfaceSubClass = 0x47,
             .bInterfaceProtocol = 0x44,
             .iInterface = 1},
            {.bLength = sizeof(usb_endpoint_descriptor_no_audio),
             .bDescriptorType = USB_DT_ENDPOINT,
             .bEndpointAddress = 1 | USB_DIR_IN,
             .bmAttributes = USB_ENDPOINT_XFER_BULK,
             .wMaxPacketSize = packet_bytes,
             .bInterval = 0}};
}

constexpr Digitiser_descriptors digitiser_descriptors = {
    {FUNCTIONFS_DESCRIPTORS_MAGIC_V2, sizeof(Digitiser_descriptors), FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_HAS_HS_DESC},
    2,
    2,
    digitiser_interface(64),
    digitiser_interface(512)};

constexpr Digitiser_strings digitiser_strings = {
    {FUNCTIONFS_STRINGS_MAGIC, sizeof(Digitiser_strings), 1, 1}, 0x0409, {"gonio digitiser"}};

} // namespace gonio::sim
