/* ffs_descriptors.c: written byte by byte, little-endian, as USB and FunctionFS have them. */
#include "ffs_descriptors.h"

#include <linux/usb/ch9.h>
#include <linux/usb/functionfs.h>
#include <string.h>

#define LINK_SUBCLASS 0x47u /* protocol/link.md */
#define LINK_PROTOCOL 0x4Cu
#define INTERFACE_STRING "gonio link"
#define LANGUAGE_ENGLISH_US 0x0409u

#define COMPATIBLE_ID_INDEX 4u /* wIndex of the two kinds of Microsoft OS feature descriptors */
#define PROPERTIES_INDEX 5u
#define PROPERTY_STRING 1u /* REG_SZ: the kernel does not pass on REG_MULTI_SZ, hence the property's singular name */
#define PROPERTY_NAME "DeviceInterfaceGUID"
#define PROPERTY_VALUE "{8D7C1E52-3B0A-4F64-9C55-6A2E90B7F4D1}"

struct writer {
    uint8_t *bytes;
    size_t length;
};

static void put(struct writer *writer, uint32_t value, uint32_t size) {
    for (uint32_t i = 0; i < size; ++i) {
        writer->bytes[writer->length++] = (uint8_t)(value >> (8u * i));
    }
}

static void put_text(struct writer *writer, const char *text, size_t size) {
    memset(writer->bytes + writer->length, 0, size);
    memcpy(writer->bytes + writer->length, text, strlen(text));
    writer->length += size;
}

static void put_interface(struct writer *writer) {
    uint8_t const descriptor[USB_DT_INTERFACE_SIZE] = {
        USB_DT_INTERFACE_SIZE, USB_DT_INTERFACE, 0, 0, 2, USB_CLASS_VENDOR_SPEC, LINK_SUBCLASS, LINK_PROTOCOL, 1};
    memcpy(writer->bytes + writer->length, descriptor, sizeof descriptor);
    writer->length += sizeof descriptor;
}

static void put_endpoint(struct writer *writer, uint8_t address, uint32_t packet_size) {
    put(writer, USB_DT_ENDPOINT_SIZE, 1);
    put(writer, USB_DT_ENDPOINT, 1);
    put(writer, address, 1);
    put(writer, USB_ENDPOINT_XFER_BULK, 1);
    put(writer, packet_size, 2);
    put(writer, 0, 1);
}

static void put_companion(struct writer *writer) {
    put(writer, USB_DT_SS_EP_COMP_SIZE, 1);
    put(writer, USB_DT_SS_ENDPOINT_COMP, 1);
    put(writer, 0, 4); /* no burst, no streams */
}

static void put_speed(struct writer *writer, uint32_t packet_size) {
    put_interface(writer);
    put_endpoint(writer, USB_DIR_IN | 1u, packet_size);
    put_endpoint(writer, USB_DIR_OUT | 2u, packet_size);
}

static void put_super_speed(struct writer *writer) {
    put_interface(writer);
    put_endpoint(writer, USB_DIR_IN | 1u, 1024);
    put_companion(writer);
    put_endpoint(writer, USB_DIR_OUT | 2u, 1024);
    put_companion(writer);
}

/* A feature descriptor with one entry of `size` bytes. */
static void put_os_header(struct writer *writer, uint32_t index, uint32_t size) {
    put(writer, 0, 1); /* interface */
    put(writer, 11u + size, 4);
    put(writer, 1, 2); /* version, as FunctionFS wants it */
    put(writer, index, 2);
    put(writer, 1, 2); /* entries */
}

static void put_os_descriptors(struct writer *writer) {
    uint32_t const compatible_id_size = 24;
    put_os_header(writer, COMPATIBLE_ID_INDEX, compatible_id_size);
    put(writer, 0, 1); /* interface */
    put(writer, 1, 1); /* reserved, 1 */
    put_text(writer, "WINUSB", 8);
    put_text(writer, "", 8);
    put_text(writer, "", 6);

    /* Names and strings in 8 bits, with their final 0; the kernel widens them. */
    uint32_t const property_size = 14u + (uint32_t)sizeof PROPERTY_NAME + (uint32_t)sizeof PROPERTY_VALUE;
    put_os_header(writer, PROPERTIES_INDEX, property_size);
    put(writer, property_size, 4);
    put(writer, PROPERTY_STRING, 4);
    put(writer, sizeof PROPERTY_NAME, 2);
    put_text(writer, PROPERTY_NAME, sizeof PROPERTY_NAME);
    put(writer, sizeof PROPERTY_VALUE, 4);
    put_text(writer, PROPERTY_VALUE, sizeof PROPERTY_VALUE);
}

static void put_length(struct writer *writer) {
    struct writer place = {.bytes = writer->bytes, .length = 4};
    put(&place, (uint32_t)writer->length, 4);
}

size_t gn_ffs_descriptors(uint8_t bytes[GN_FFS_DESCRIPTORS_MAX]) {
    struct writer writer = {.bytes = bytes};
    put(&writer, FUNCTIONFS_DESCRIPTORS_MAGIC_V2, 4);
    put(&writer, 0, 4); /* the length, when it is known */
    put(&writer, FUNCTIONFS_HAS_FS_DESC | FUNCTIONFS_HAS_HS_DESC | FUNCTIONFS_HAS_SS_DESC | FUNCTIONFS_HAS_MS_OS_DESC,
        4);
    put(&writer, 3, 4); /* descriptors at full, high and super speed; OS descriptors */
    put(&writer, 3, 4);
    put(&writer, 5, 4);
    put(&writer, 2, 4);
    put_speed(&writer, 64);
    put_speed(&writer, 512);
    put_super_speed(&writer);
    put_os_descriptors(&writer);
    put_length(&writer);
    return writer.length;
}

size_t gn_ffs_strings(uint8_t bytes[GN_FFS_STRINGS_MAX]) {
    struct writer writer = {.bytes = bytes};
    put(&writer, FUNCTIONFS_STRINGS_MAGIC, 4);
    put(&writer, 0, 4);
    put(&writer, 1, 4); /* strings */
    put(&writer, 1, 4); /* languages */
    put(&writer, LANGUAGE_ENGLISH_US, 2);
    put_text(&writer, INTERFACE_STRING, sizeof INTERFACE_STRING);
    put_length(&writer);
    return writer.length;
}
