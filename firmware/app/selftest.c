/* selftest.c: the checks in order, one line each. */
#include "selftest.h"

#include <stdio.h>

#include "session.h"

bool gn_selftest(void) {
    static const struct {
        const char *name;
        gn_selftest_check *check;
    } checks[] = {
        {"records: sizes and byte order", gn_selftest_records},
        {"CRC-32C: known answers", gn_selftest_crc32c},
        {"frames: golden bytes", gn_selftest_frames},
        {"messages: there and back", gn_selftest_messages},
        {"ring between two threads", gn_selftest_ring},
        {"firmware and a host over loopback TCP", gn_selftest_firmware},
    };
    bool all = true;
    printf("goniod self-test, %s\n", GN_FIRMWARE_NAME);
    for (size_t i = 0; i < sizeof checks / sizeof checks[0]; ++i) {
        char what[256] = "";
        bool const good = checks[i].check(what, sizeof what);
        printf("%-6s %s%s%s\n", good ? "good" : "FAILED", checks[i].name, what[0] == '\0' ? "" : ": ", what);
        (void)fflush(stdout);
        all = all && good;
    }
    return all;
}
