/* ffs_descriptors.h: what FunctionFS is told about the link's interface: descriptors for each speed, a string, and the
 * Microsoft OS descriptors with which Windows loads WinUSB by itself. */
#ifndef GONIO_FFS_DESCRIPTORS_H
#define GONIO_FFS_DESCRIPTORS_H

#include <stddef.h>
#include <stdint.h>

#define GN_FFS_DESCRIPTORS_MAX 512u
#define GN_FFS_STRINGS_MAX 64u

/* Bytes to be written to ep0 first. The endpoint files: ep1 is bulk IN, ep2 bulk OUT. */
size_t gn_ffs_descriptors(uint8_t bytes[GN_FFS_DESCRIPTORS_MAX]);
/* Bytes to be written to ep0 second. */
size_t gn_ffs_strings(uint8_t bytes[GN_FFS_STRINGS_MAX]);

#endif
