/* selftest_threads.c: two threads and the ring between them; then the whole firmware without devices, asked by a host
 * over loopback TCP. */
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "assembly.h"
#include "null_port.h"
#include "selftest.h"
#include "selftest_client.h"

#define RING_RECORDS 200000u
#define RING_CAPACITY 64u
#define DEVICE_NAME "self-test"
#define ASKS_MAX 1000 /* for the end of a connection; each takes a round of the stream thread */

static void *push_all(void *context) {
    for (uint64_t i = 0; i < RING_RECORDS;) {
        uint64_t const record[2] = {i, ~i};
        i += gn_ring_push(context, record) ? 1u : 0u;
    }
    return NULL;
}

bool gn_selftest_ring(char *what, size_t size) {
    static uint64_t slots[RING_CAPACITY][2];
    struct gn_ring ring;
    pthread_t pusher;
    gn_ring_init(&ring, slots, sizeof slots[0], RING_CAPACITY);
    if (pthread_create(&pusher, NULL, push_all, &ring) != 0) {
        (void)snprintf(what, size, "no second thread to be had");
        return false;
    }
    uint64_t wrong = 0;
    for (uint64_t i = 0; i < RING_RECORDS;) {
        uint64_t record[2] = {0, 0};
        if (gn_ring_pop(&ring, record)) {
            wrong += record[0] != i || record[1] != ~i ? 1u : 0u;
            ++i;
        }
    }
    (void)pthread_join(pusher, NULL);
    if (wrong != 0u) {
        (void)snprintf(what, size, "%llu of %u records came out wrong", (unsigned long long)wrong, RING_RECORDS);
    }
    return wrong == 0u;
}

/* The host's side of the last check, on a thread of its own. */
struct host {
    uint16_t port;
    int stop_fd;
    uint64_t session;
    const char *kernel;
    gonio_Latency latency[2]; /* motion, stream */
    const char *failed;       /* the step; NULL: none */
};

static bool histogram_holds(const gonio_Latency *latency) {
    uint64_t sum = 0;
    for (pb_size_t i = 0; i < latency->bins_count; ++i) {
        sum += latency->bins[i];
    }
    /* The other thread counts on while the histogram is copied: one wake-up may be in only one of the two. */
    return latency->wakeups > 0u && latency->bins_count == GN_LATENCY_BINS && sum + 1u >= latency->wakeups &&
           sum <= latency->wakeups + 1u;
}

/* The histograms of both threads come once per second. */
static bool hear_latency(struct gn_selftest_client *client, struct host *host) {
    bool heard[2] = {false, false};
    while (!heard[0] || !heard[1]) {
        static gonio_Reply reply;
        static gonio_Event event;
        bool is_reply = false;
        if (!gn_selftest_next(client, &is_reply, &reply, &event)) {
            return false;
        }
        if (!is_reply && event.which_body == gonio_Event_latency_tag) {
            int const thread = event.body.latency.thread == gonio_Thread_THREAD_MOTION ? 0 : 1;
            host->latency[thread] = event.body.latency;
            /* The first may be of the moment before the first wake-up. */
            heard[thread] = histogram_holds(&event.body.latency);
        }
    }
    return true;
}

static bool info_holds(const struct host *host, const gonio_Reply *reply, bool driver) {
    const gonio_Info *info = &reply->body.info;
    return reply->code == gonio_ReplyCode_REPLY_OK && reply->which_body == gonio_Reply_info_tag &&
           info->state == gonio_InstrumentState_STATE_UNCONFIGURED && strcmp(info->device, DEVICE_NAME) == 0 &&
           strcmp(info->kernel, host->kernel) == 0 && info->driver_connected == driver;
}

static bool ask_info(struct gn_selftest_client *client, uint32_t id, gonio_Reply *reply) {
    gonio_Request request = gonio_Request_init_zero;
    request.id = id;
    request.which_body = gonio_Request_get_info_tag;
    return gn_selftest_request(client, &request) && gn_selftest_reply(client, id, reply);
}

static bool ask_stop(struct gn_selftest_client *client, uint32_t id) {
    static gonio_Reply reply;
    gonio_Request request = gonio_Request_init_zero;
    request.id = id;
    request.which_body = gonio_Request_stop_tag;
    (void)strcpy(request.body.stop.reason, "self-test");
    return gn_selftest_request(client, &request) && gn_selftest_reply(client, id, &reply) &&
           reply.code == gonio_ReplyCode_REPLY_OK;
}

/* After the driver's end a visitor is told that nobody drives. */
static bool close_is_seen(struct host *host) {
    static struct gn_selftest_client visitor;
    static gonio_Reply reply;
    gonio_Hello hello = gonio_Hello_init_zero;
    bool seen = false;
    bool good = gn_selftest_connect(&visitor, host->port, gonio_Role_ROLE_VISITOR, &hello);
    for (uint32_t id = 1; good && !seen && id <= ASKS_MAX; ++id) {
        good = ask_info(&visitor, id, &reply);
        seen = good && info_holds(host, &reply, false);
    }
    gn_selftest_disconnect(&visitor);
    return seen;
}

static const char *drive(struct host *host) {
    static struct gn_selftest_client client;
    static gonio_Reply reply;
    gonio_Hello hello = gonio_Hello_init_zero;
    const char *failed = NULL;
    if (!gn_selftest_connect(&client, host->port, gonio_Role_ROLE_DRIVER, &hello) ||
        hello.schema_hash != GN_SCHEMA_HASH || hello.session_id != host->session) {
        failed = "HELLO was not answered well";
    } else if (!ask_info(&client, 1u, &reply) || !info_holds(host, &reply, true)) {
        failed = "GetInfo was not answered well";
    } else if (!ask_stop(&client, 2u)) {
        failed = "Stop was not answered well";
    } else if (!hear_latency(&client, host)) {
        failed = "no latency histogram of both threads came";
    }
    gn_selftest_disconnect(&client);
    return failed;
}

static void *host_thread(void *context) {
    struct host *host = context;
    host->failed = drive(host);
    if (host->failed == NULL && !close_is_seen(host)) {
        host->failed = "the end of the driver's connection was not seen";
    }
    uint64_t const one = 1;
    (void)!write(host->stop_fd, &one, sizeof one);
    return NULL;
}

/* Runs the firmware until the host ends it. */
static bool run_firmware(struct gn_threads *threads, struct host *host, char *what, size_t size) {
    pthread_t thread;
    struct gn_thread_settings const ordinary = {.motion_priority = 0, .stream_priority = 0, .motion_cpu = -1};
    if (pthread_create(&thread, NULL, host_thread, host) != 0) {
        (void)snprintf(what, size, "no second thread to be had");
        return false;
    }
    bool const ran = gn_threads_run(threads, &ordinary, what, size) == 0;
    gn_link_linux_close(threads->link); /* if it did not run, the host must not wait */
    (void)pthread_join(thread, NULL);
    if (ran && host->failed != NULL) {
        (void)snprintf(what, size, "%s", host->failed);
    }
    return ran && host->failed == NULL;
}

bool gn_selftest_firmware(char *what, size_t size) {
    static struct gn_shared shared;
    static struct gn_port port;
    struct gn_link_settings const link = {.functionfs = "", .tcp_port = 0, .tcp = true};
    struct gn_threads threads = {.link = gn_link_linux_open(&link, what, size), .shared = &shared};
    if (threads.link == NULL) {
        return false;
    }
    gn_null_port(&port);
    gn_link_linux_port(threads.link, &port.link);
    gn_shared_init(&shared);
    shared.kernel = "self-test's kernel";
    struct host host = {.port = gn_link_linux_tcp_port(threads.link),
                        .stop_fd = eventfd(0, EFD_CLOEXEC),
                        .session = gn_session_number(),
                        .kernel = shared.kernel};
    threads.motion = gn_motion_init(&port, &shared);
    threads.stream = gn_stream_init(&port, &shared, DEVICE_NAME, host.session);
    threads.stop_fd = host.stop_fd;
    bool const good = run_firmware(&threads, &host, what, size);
    (void)close(host.stop_fd);
    if (good) {
        (void)snprintf(what, size, "woken %llu and %llu times, at most %u and %u us late (motion, stream)",
                       (unsigned long long)host.latency[0].wakeups, (unsigned long long)host.latency[1].wakeups,
                       (unsigned)host.latency[0].max_us, (unsigned)host.latency[1].max_us);
    }
    return good;
}
