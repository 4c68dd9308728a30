/* assembly.h: goniod put together: devices opened, seams joined with the core, both threads run, all closed again. */
#ifndef GONIO_ASSEMBLY_H
#define GONIO_ASSEMBLY_H

#include <stdbool.h>
#include <stddef.h>

#include "config.h"
#include "log_stream.h"

struct gn_assembly {
    const struct gn_config *config;
    struct gn_log_stream *log;
    struct gn_port port;
    struct gn_shared shared;
    struct gn_threads threads;
    char kernel[96];
    int watchdog_fd;         /* -1: none */
    int64_t notify_every_ns; /* 0: systemd does not ask */
    int64_t notify_due_ns;
    bool ready; /* both threads were seen alive, and systemd and standard output know */
};

/* false, and one line in `error`; what was opened is closed again. */
bool gn_assembly_open(struct gn_assembly *assembly, const struct gn_config *config, struct gn_log_stream *log,
                      char *error, size_t error_size);
/* Until stop_fd becomes readable; 0, or -1 with one line in `error`. */
int gn_assembly_run(struct gn_assembly *assembly, int stop_fd, char *error, size_t error_size);
void gn_assembly_close(struct gn_assembly *assembly);
/* A number that no session before had. */
uint64_t gn_session_number(void);

#endif
