// sdo_server.hpp: one SDO server (CiA 301): expedited and segmented transfers over an object dictionary.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "object_dictionary.hpp"

namespace gonio::sim {

// What the device has to say about an access beyond type, access right and limits.
class Object_guard {
public:
    virtual ~Object_guard() = default;
    // Bring the value up to date; an abort code, or abort_code::none.
    virtual std::uint32_t before_read(Od_entry &entry) = 0;
    // An abort code if the device does not take this value now.
    virtual std::uint32_t before_write(const Od_entry &entry, std::int64_t value) = 0;
    virtual void after_write(Od_entry &entry) = 0;
};

class Sdo_server {
public:
    using Message = std::array<std::uint8_t, 8>;

    Sdo_server(Object_dictionary &dictionary, Object_guard &guard) : dictionary_(dictionary), guard_(guard) {}

    // The answer to a request; none to an abort of the client.
    std::optional<Message> answer(const Message &request, std::int64_t now_ns);
    // The abort of a segmented transfer whose client has gone silent.
    std::optional<Message> check_timeout(std::int64_t now_ns);
    // Forget a transfer (NMT reset or stop).
    void reset() { transfer_ = Transfer::none; }

    [[nodiscard]] std::uint64_t aborts() const { return aborts_; }

private:
    enum class Transfer { none, upload, download };

    Message begin_upload(const Message &request);
    Message upload_segment(const Message &request);
    Message begin_download(const Message &request);
    Message download_segment(const Message &request);
    std::uint32_t locate(const Message &request);
    std::uint32_t store();
    Message abort(std::uint32_t code);
    [[nodiscard]] Message initiate(std::uint8_t command) const;

    Object_dictionary &dictionary_;
    Object_guard &guard_;
    Transfer transfer_ = Transfer::none;
    std::uint16_t index_ = 0; // of the current or last request, for aborts
    std::uint8_t subindex_ = 0;
    Od_entry *entry_ = nullptr;
    std::vector<std::uint8_t> bytes_;
    std::size_t sent_ = 0;
    std::optional<std::uint32_t> announced_; // bytes, if the client of a download said how many
    bool toggle_ = false;
    std::int64_t last_ns_ = 0;
    std::uint64_t aborts_ = 0;
};

} // namespace gonio::sim
