// usb_digitiser.cpp: vendor requests on ep0; bulk transfers by Linux AIO, so that a host that does not read holds
// nobody up.
#include "usb_digitiser.hpp"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <linux/usb/ch9.h>
#include <linux/usb/functionfs.h>
#include <sys/eventfd.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "toml_table.hpp"
#include "usb_descriptors.hpp"

namespace gonio::sim {
namespace {

constexpr std::uint8_t vendor_to_interface = USB_DIR_OUT | USB_TYPE_VENDOR | USB_RECIP_INTERFACE;
constexpr std::uint8_t request_start = 1;
constexpr std::uint8_t request_stop = 2;

// glibc has no wrappers for them.
long io_setup(unsigned count, aio_context_t *context) {
    return syscall(SYS_io_setup, count, context);
}
long io_submit(aio_context_t context, long count, iocb **requests) {
    return syscall(SYS_io_submit, context, count, requests);
}
long io_getevents(aio_context_t context, long least, long most, io_event *events, timespec *timeout) {
    return syscall(SYS_io_getevents, context, least, most, events, timeout);
}
long io_cancel(aio_context_t context, iocb *request, io_event *event) {
    return syscall(SYS_io_cancel, context, request, event);
}

int open_endpoint(const std::filesystem::path &path, int mode) {
    int const file = open(path.c_str(), mode | O_CLOEXEC);
    if (file < 0) {
        throw Input_error("--digitiser " + path.string() + ": cannot be opened (" + std::strerror(errno) +
                          "); name the folder where FunctionFS is mounted");
    }
    return file;
}

template <typename Block> void write_block(int file, const Block &block, const std::filesystem::path &directory) {
    if (write(file, &block, sizeof block) != static_cast<ssize_t>(sizeof block)) {
        std::string const why = std::strerror(errno);
        close(file);
        throw Input_error("--digitiser " + directory.string() + ": the kernel refuses the descriptors (" + why +
                          "); is the function in use by another program?");
    }
}

} // namespace

Function_files open_functionfs(const std::filesystem::path &directory) {
    int const control = open_endpoint(directory / "ep0", O_RDWR | O_NONBLOCK);
    write_block(control, digitiser_descriptors, directory);
    write_block(control, digitiser_strings, directory);
    return {control, open_endpoint(directory / "ep1", O_RDWR)};
}

Usb_digitiser::Usb_digitiser(const Function_files &files, Digitiser &digitiser)
    : files_(files), digitiser_(digitiser), completed_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    if (io_setup(transfers_in_flight, &context_) != 0) {
        throw Input_error(std::string("--digitiser: this kernel has no asynchronous transfers (") +
                          std::strerror(errno) + "); it needs CONFIG_AIO");
    }
}

Usb_digitiser::~Usb_digitiser() {
    syscall(SYS_io_destroy, context_);
    close(completed_);
    close(files_.bulk_in);
    close(files_.control);
}

void Usb_digitiser::wait_for(std::vector<pollfd> &descriptors) const {
    descriptors.push_back({files_.control, POLLIN, 0});
    descriptors.push_back({completed_, POLLIN, 0});
}

void Usb_digitiser::serve() {
    handle_events();
    collect();
    pump();
}

// One event at a time: a SETUP's data must be taken before anything else is read.
void Usb_digitiser::handle_events() {
    usb_functionfs_event event{};
    while (read(files_.control, &event, sizeof event) == static_cast<ssize_t>(sizeof event)) {
        if (event.type == FUNCTIONFS_SETUP) {
            setup(event.u.setup.bRequestType, event.u.setup.bRequest, event.u.setup.wLength);
        } else if (event.type == FUNCTIONFS_DISABLE || event.type == FUNCTIONFS_UNBIND) {
            digitiser_.stop(); // the bus is its supply: unplugged, it forgets that it was started
            cancel();
        }
    }
}

void Usb_digitiser::setup(std::uint8_t type, std::uint8_t request, std::uint16_t length) {
    std::array<std::uint32_t, 2> values{};
    if (type == vendor_to_interface && request == request_start && length == sizeof values) {
        if (read(files_.control, values.data(), sizeof values) == static_cast<ssize_t>(sizeof values)) {
            begin(values[0], values[1]);
        }
    } else if (type == vendor_to_interface && request == request_stop && length == 0) {
        digitiser_.stop();
        // To read nothing is to acknowledge.
        if (read(files_.control, nullptr, 0) < 0) {
            cancel();
        }
    } else if ((type & USB_DIR_IN) != 0) { // To move data the wrong way is to stall.
        [[maybe_unused]] ssize_t const stalled = read(files_.control, nullptr, 0);
    } else {
        [[maybe_unused]] ssize_t const stalled = write(files_.control, nullptr, 0);
    }
}

void Usb_digitiser::begin(std::uint32_t sample_period_us, std::uint32_t samples_per_strobe) {
    digitiser_.stop();
    cancel();
    digitiser_.start(sample_period_us, samples_per_strobe);
}

void Usb_digitiser::pump() {
    for (Transfer &transfer : transfers_) {
        if (transfer.in_flight) {
            continue;
        }
        int const length = digitiser_.read(transfer.bytes.data(), transfer.bytes.size());
        if (length == 0) {
            return;
        }
        transfer.request = {};
        transfer.request.aio_data = static_cast<std::uint64_t>(&transfer - transfers_.data());
        transfer.request.aio_lio_opcode = IOCB_CMD_PWRITE;
        transfer.request.aio_fildes = static_cast<std::uint32_t>(files_.bulk_in);
        transfer.request.aio_buf = reinterpret_cast<std::uint64_t>(transfer.bytes.data());
        transfer.request.aio_nbytes = static_cast<std::uint64_t>(length);
        transfer.request.aio_flags = IOCB_FLAG_RESFD;
        transfer.request.aio_resfd = static_cast<std::uint32_t>(completed_);
        iocb *request = &transfer.request;
        // Refused while nothing is plugged in: the packet is gone, and its number tells.
        transfer.in_flight = io_submit(context_, 1, &request) == 1;
    }
}

void Usb_digitiser::collect() {
    std::uint64_t count = 0;
    while (read(completed_, &count, sizeof count) == static_cast<ssize_t>(sizeof count)) {
        std::array<io_event, transfers_in_flight> events{};
        timespec at_once{};
        long const done = io_getevents(context_, 0, static_cast<long>(events.size()), events.data(), &at_once);
        for (long i = 0; i < done; ++i) {
            transfers_.at(events.at(static_cast<std::size_t>(i)).data).in_flight = false;
        }
    }
}

// What is cancelled still completes, with an error; until then its buffer is the kernel's.
void Usb_digitiser::cancel() {
    for (Transfer &transfer : transfers_) {
        io_event event{};
        if (transfer.in_flight) {
            io_cancel(context_, &transfer.request, &event);
        }
    }
    collect();
}

} // namespace gonio::sim
