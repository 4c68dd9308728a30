/* log_stream.h: the log's seam: `<level>text` lines on a file descriptor (standard error, which systemd reads). Any
 * thread may write and none ever waits: a lock-free ring holds the lines for a thread of ordinary priority that writes
 * them out. */
#ifndef GONIO_LOG_STREAM_H
#define GONIO_LOG_STREAM_H

#include <stdbool.h>

#include "log.h"

struct gn_log_stream; /* one static instance */

/* Starts the writing thread. NULL: there is no thread to be had. */
struct gn_log_stream *gn_log_stream_open(int fd);
/* Writes what waits and ends the thread. */
void gn_log_stream_close(struct gn_log_stream *log);
void gn_log_stream_port(struct gn_log_stream *log, struct gn_log_port *port);

#endif
