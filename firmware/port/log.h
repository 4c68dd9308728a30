/* log.h: the seam of the diagnostic log; a full log drops the line, it never blocks. */
#ifndef GONIO_PORT_LOG_H
#define GONIO_PORT_LOG_H

enum gn_log_level { GN_LOG_ERROR = 3, GN_LOG_WARNING = 4, GN_LOG_INFO = 6 };

struct gn_log_port {
    void *context;
    void (*write)(void *context, enum gn_log_level level, const char *text);
};

#endif
