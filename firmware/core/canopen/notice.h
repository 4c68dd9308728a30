/* notice.h: replies and events to the stream side. */
#ifndef GONIO_NOTICE_H
#define GONIO_NOTICE_H

#include "motion_state.h"

void gn_reply(struct gn_motion *motion, uint32_t request_id, gonio_ReplyCode code, const char *text);
void gn_reply_with(struct gn_motion *motion, const gonio_Reply *reply);
/* time_ns is filled in. */
void gn_event(struct gn_motion *motion, gonio_Event *event);
void gn_event_path(struct gn_motion *motion, gonio_PathEnd end);
void gn_notice_log(struct gn_motion *motion, uint32_t level, const char *text);
void gn_event_status(struct gn_motion *motion);
/* Ends the operation under way, if any. */
void gn_operation_done(struct gn_motion *motion, gonio_ReplyCode code, const char *text);
uint32_t gn_known_mask(const struct gn_motion *motion);

#endif
