/* selftest.h: `goniod --self-test`: what may differ from processor to processor and from compiler to compiler, checked
 * without any device. */
#ifndef GONIO_SELFTEST_H
#define GONIO_SELFTEST_H

#include <stdbool.h>
#include <stddef.h>

/* Prints one line per check; true: all are good. */
bool gn_selftest(void);

/* The checks. false, and one line in `what`: what was expected and what was found. */
typedef bool gn_selftest_check(char *what, size_t size);
gn_selftest_check gn_selftest_records;
gn_selftest_check gn_selftest_crc32c;
gn_selftest_check gn_selftest_frames;
gn_selftest_check gn_selftest_messages;
gn_selftest_check gn_selftest_ring;
gn_selftest_check gn_selftest_firmware; /* on success `what` holds the threads' latency */

#endif
