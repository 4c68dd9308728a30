// usb_digitiser.hpp: the simulated digitiser as a USB gadget: FunctionFS's ep0 and one bulk IN endpoint.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>

#include <linux/aio_abi.h>

#include "digitiser.hpp"
#include "event_loop.hpp"

namespace gonio::sim {

// Descriptors of an opened function; they become the gadget's.
struct Function_files {
    int control; // ep0
    int bulk_in;
};

// Writes the descriptors (protocol/digitiser.md) and opens the endpoints; the gadget may be bound afterwards. Throws
// Input_error.
Function_files open_functionfs(const std::filesystem::path &directory);

class Usb_digitiser final : public Source {
public:
    Usb_digitiser(const Function_files &files, Digitiser &digitiser);
    ~Usb_digitiser() override;
    Usb_digitiser(const Usb_digitiser &) = delete;
    Usb_digitiser &operator=(const Usb_digitiser &) = delete;
    Usb_digitiser(Usb_digitiser &&) = delete;
    Usb_digitiser &operator=(Usb_digitiser &&) = delete;

    void wait_for(std::vector<pollfd> &descriptors) const override;
    void serve() override;
    // Packets that wait in the digitiser become transfers, as long as there is room.
    void pump();

private:
    static constexpr std::size_t transfers_in_flight = 8;
    static constexpr std::size_t largest_packet_bytes = 12 + 255 * 16;
    struct Transfer {
        iocb request{};
        std::array<std::uint8_t, largest_packet_bytes> bytes{};
        bool in_flight = false;
    };
    void handle_events();
    void setup(std::uint8_t type, std::uint8_t request, std::uint16_t length);
    void begin(std::uint32_t sample_period_us, std::uint32_t samples_per_strobe);
    void collect();
    void cancel();

    Function_files files_;
    Digitiser &digitiser_;
    aio_context_t context_ = 0;
    int completed_; // eventfd
    std::array<Transfer, transfers_in_flight> transfers_;
};

} // namespace gonio::sim
