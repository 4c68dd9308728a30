/* commands.c: dispatches requests and answers the short ones. */
#include "commands.h"

#include <stdio.h>
#include <string.h>

#include "configure.h"
#include "input_lines.h"
#include "notice.h"
#include "operation.h"
#include "outputs.h"
#include "ride.h"

static void get_info(struct gn_motion *motion, uint32_t request_id) {
    gonio_Reply reply = {.id = request_id, .code = gonio_ReplyCode_REPLY_OK, .which_body = gonio_Reply_info_tag};
    gonio_Info *info = &reply.body.info;
    info->state = motion->state;
    info->axis_count = motion->cycle.axis_count;
    info->nodes_count = (pb_size_t)motion->cycle.axis_count;
    for (uint32_t i = 0; i < motion->cycle.axis_count; i++) {
        info->nodes[i] = motion->axes[i].info;
        info->nodes[i].node = motion->axes[i].config.node;
    }
    (void)snprintf(info->last_fault, sizeof info->last_fault, "%s", motion->last_fault.sentence);
    gn_reply_with(motion, &reply);
}

static void set_output(struct gn_motion *motion, uint32_t request_id, const gonio_SetOutput *request) {
    bool const shutter = request->output == gonio_Output_OUTPUT_SHUTTER;
    if (!shutter && request->output != gonio_Output_OUTPUT_LAMP) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_INVALID, "no such output: 1 is the shutter, 2 the lamp");
        return;
    }
    if (shutter && request->on) {
        const char *obstacle = gn_inputs_obstacle(motion);
        if (motion->state == gonio_InstrumentState_STATE_FAULT) {
            obstacle = "the shutter stays closed in a fault: clear it first";
        }
        if (obstacle != NULL) {
            gn_reply(motion, request_id, gonio_ReplyCode_REPLY_REFUSED, obstacle);
            return;
        }
    }
    gn_output_set(motion, request->output, request->on);
    gn_reply(motion, request_id, gonio_ReplyCode_REPLY_OK, "");
}

static void operator_done(struct gn_motion *motion, uint32_t request_id, const gonio_OperatorDone *request) {
    gonio_Event event = {.which_body = gonio_Event_operator_done_tag};
    event.body.operator_done = *request;
    motion->port->out.operator_done(motion->port->out.context, request->action);
    gn_event(motion, &event);
    gn_reply(motion, request_id, gonio_ReplyCode_REPLY_OK, "");
}

static void sdo_read(struct gn_motion *motion, uint32_t request_id, const gonio_SdoRead *request) {
    uint32_t i = 0;
    while (i < motion->cycle.axis_count &&
           (!motion->axes[i].configured || motion->axes[i].config.node != request->node)) {
        i++;
    }
    if (i == motion->cycle.axis_count) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_INVALID, "no axis has this node: see the instrument file");
        return;
    }
    if (motion->operation.kind != GN_OPERATION_NONE || motion->errand.pending) {
        gn_reply(motion, request_id, gonio_ReplyCode_REPLY_REFUSED, "the node's SDO is in use: try again later");
        return;
    }
    struct gn_axis *axis = &motion->axes[i];
    gn_sdo_reset(&axis->sdo);
    (void)gn_sdo_read(&axis->sdo, &motion->port->can, (uint16_t)request->index, (uint8_t)request->subindex,
                      motion->now_ns);
    motion->errand = (struct gn_sdo_errand){.pending = true, .request_id = request_id, .axis = i};
}

void gn_errand_process(struct gn_motion *motion) {
    if (!motion->errand.pending) {
        return;
    }
    struct gn_sdo *sdo = &motion->axes[motion->errand.axis].sdo;
    gonio_Reply reply = {.id = motion->errand.request_id, .code = gonio_ReplyCode_REPLY_OK};
    gn_sdo_process(sdo, &motion->port->can, motion->now_ns);
    if (sdo->state == GN_SDO_BUSY) {
        return;
    }
    if (sdo->state == GN_SDO_DONE) {
        reply.which_body = gonio_Reply_sdo_value_tag;
        reply.body.sdo_value = (gonio_SdoValue){.value = gn_sdo_value(sdo), .size = sdo->size};
    } else {
        reply.code = gonio_ReplyCode_REPLY_FAULT;
        (void)snprintf(reply.text, sizeof reply.text, "node %u, 0x%04X:%02X: %s (0x%08lX)", (unsigned)sdo->node,
                       sdo->index, sdo->subindex, gn_sdo_abort_words(sdo->abort_code), (unsigned long)sdo->abort_code);
    }
    motion->errand.pending = false;
    gn_reply_with(motion, &reply);
}

static void dispatch(struct gn_motion *motion, const gonio_Request *request) {
    switch (request->which_body) {
    case gonio_Request_get_info_tag:
        get_info(motion, request->id);
        break;
    case gonio_Request_configure_tag:
        gn_configure_request(motion, request->id, &request->body.configure);
        break;
    case gonio_Request_configure_axis_tag:
        gn_configure_axis_request(motion, request->id, &request->body.configure_axis);
        break;
    case gonio_Request_configure_zone_tag:
        gn_configure_zone_request(motion, request->id, &request->body.configure_zone);
        break;
    case gonio_Request_boot_tag:
        gn_boot_request(motion, request->id);
        break;
    case gonio_Request_home_tag:
        gn_home_request(motion, request->id, request->body.home.axis_mask);
        break;
    case gonio_Request_motion_begin_tag:
        gn_ride_begin(motion, request);
        break;
    case gonio_Request_set_output_tag:
        set_output(motion, request->id, &request->body.set_output);
        break;
    case gonio_Request_operator_done_tag:
        operator_done(motion, request->id, &request->body.operator_done);
        break;
    case gonio_Request_clear_fault_tag:
        gn_clear_fault_request(motion, request->id);
        break;
    case gonio_Request_release_tag:
        gn_release_request(motion, request->id);
        break;
    case gonio_Request_sdo_read_tag:
        sdo_read(motion, request->id, &request->body.sdo_read);
        break;
    default:
        gn_reply(motion, request->id, gonio_ReplyCode_REPLY_INVALID, "not a request that the motion side knows");
        break;
    }
}

void gn_commands_process(struct gn_motion *motion) {
    struct gn_command command;
    while (gn_ring_pop(&motion->shared->commands, &command)) {
        dispatch(motion, &command.request);
    }
}
