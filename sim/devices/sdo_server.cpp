// sdo_server.cpp: expedited and segmented SDO transfers, server side.
#include "sdo_server.hpp"

#include <algorithm>

namespace gonio::sim {
namespace {

// A client that stays silent this long within a segmented transfer has gone.
constexpr std::int64_t client_timeout_ns = 1'000'000'000;
constexpr std::size_t longest_download = 256;

} // namespace

std::optional<Sdo_server::Message> Sdo_server::answer(const Message &request, std::int64_t now_ns) {
    last_ns_ = now_ns;
    switch (request[0] >> 5U) { // client command specifier
    case 0:
        return download_segment(request);
    case 1:
        return begin_download(request);
    case 2:
        return begin_upload(request);
    case 3:
        return upload_segment(request);
    case 4:
        transfer_ = Transfer::none;
        return std::nullopt;
    default: // block transfers are not offered
        index_ = static_cast<std::uint16_t>(request[1] | request[2] << 8U);
        subindex_ = request[3];
        return abort(abort_code::unknown_command);
    }
}

std::optional<Sdo_server::Message> Sdo_server::check_timeout(std::int64_t now_ns) {
    if (transfer_ == Transfer::none || now_ns - last_ns_ < client_timeout_ns) {
        return std::nullopt;
    }
    return abort(abort_code::timed_out);
}

std::uint32_t Sdo_server::locate(const Message &request) {
    transfer_ = Transfer::none;
    index_ = static_cast<std::uint16_t>(request[1] | request[2] << 8U);
    subindex_ = request[3];
    entry_ = dictionary_.find(index_, subindex_);
    if (entry_ != nullptr) {
        return abort_code::none;
    }
    return dictionary_.has_index(index_) ? abort_code::no_subindex : abort_code::no_object;
}

Sdo_server::Message Sdo_server::initiate(std::uint8_t command) const {
    return {command, static_cast<std::uint8_t>(index_), static_cast<std::uint8_t>(index_ >> 8U), subindex_, 0, 0, 0, 0};
}

Sdo_server::Message Sdo_server::abort(std::uint32_t code) {
    transfer_ = Transfer::none;
    ++aborts_;
    Message message = initiate(0x80);
    value_to_bytes(code, &message[4], 4);
    return message;
}

Sdo_server::Message Sdo_server::begin_upload(const Message &request) {
    if (const std::uint32_t code = locate(request); code != abort_code::none) {
        return abort(code);
    }
    if (!entry_->readable) {
        return abort(abort_code::write_only);
    }
    if (const std::uint32_t code = guard_.before_read(*entry_); code != abort_code::none) {
        return abort(code);
    }
    if (!entry_->is_string && entry_->size <= 4) {
        Message message = initiate(static_cast<std::uint8_t>(0x43U | (4U - entry_->size) << 2U));
        value_to_bytes(entry_->value, &message[4], entry_->size);
        return message;
    }
    bytes_.assign(entry_->text.begin(), entry_->text.end());
    transfer_ = Transfer::upload;
    sent_ = 0;
    toggle_ = false;
    Message message = initiate(0x41);
    value_to_bytes(static_cast<std::int64_t>(bytes_.size()), &message[4], 4);
    return message;
}

Sdo_server::Message Sdo_server::upload_segment(const Message &request) {
    if (transfer_ != Transfer::upload) {
        return abort(abort_code::unknown_command);
    }
    if (((request[0] & 0x10U) != 0) != toggle_) {
        return abort(abort_code::toggle_not_alternated);
    }
    const std::size_t count = std::min<std::size_t>(7, bytes_.size() - sent_);
    const bool last = sent_ + count == bytes_.size();
    Message message{};
    message[0] =
        static_cast<std::uint8_t>((toggle_ ? 0x10U : 0U) | static_cast<unsigned>(7 - count) << 1U | (last ? 1U : 0U));
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(sent_), count, message.begin() + 1);
    sent_ += count;
    toggle_ = !toggle_;
    if (last) {
        transfer_ = Transfer::none;
    }
    return message;
}

Sdo_server::Message Sdo_server::begin_download(const Message &request) {
    if (const std::uint32_t code = locate(request); code != abort_code::none) {
        return abort(code);
    }
    if (!entry_->writable) {
        return abort(abort_code::read_only);
    }
    const bool expedited = (request[0] & 2U) != 0;
    const bool size_indicated = (request[0] & 1U) != 0;
    bytes_.clear();
    if (expedited) {
        const std::size_t count = size_indicated ? 4U - (request[0] >> 2U & 3U) : std::min<unsigned>(4, entry_->size);
        bytes_.assign(request.begin() + 4, request.begin() + 4 + static_cast<std::ptrdiff_t>(count));
        const std::uint32_t code = store();
        return code == abort_code::none ? initiate(0x60) : abort(code);
    }
    announced_.reset();
    if (size_indicated) {
        announced_ = static_cast<std::uint32_t>(value_from_bytes(&request[4], 4, false));
        if (*announced_ > longest_download || (!entry_->is_string && *announced_ != entry_->size)) {
            return abort(abort_code::wrong_length);
        }
    }
    transfer_ = Transfer::download;
    toggle_ = false;
    return initiate(0x60);
}

Sdo_server::Message Sdo_server::download_segment(const Message &request) {
    if (transfer_ != Transfer::download) {
        return abort(abort_code::unknown_command);
    }
    if (((request[0] & 0x10U) != 0) != toggle_) {
        return abort(abort_code::toggle_not_alternated);
    }
    const std::ptrdiff_t count = 7 - (request[0] >> 1U & 7U);
    bytes_.insert(bytes_.end(), request.begin() + 1, request.begin() + 1 + count);
    if (bytes_.size() > longest_download) {
        return abort(abort_code::wrong_length);
    }
    if ((request[0] & 1U) != 0) {
        if (announced_ && *announced_ != bytes_.size()) {
            return abort(abort_code::wrong_length);
        }
        if (const std::uint32_t code = store(); code != abort_code::none) {
            return abort(code);
        }
        transfer_ = Transfer::none;
    }
    Message message{};
    message[0] = static_cast<std::uint8_t>(0x20U | (toggle_ ? 0x10U : 0U));
    toggle_ = !toggle_;
    return message;
}

std::uint32_t Sdo_server::store() {
    if (entry_->is_string) {
        entry_->text.assign(bytes_.begin(), bytes_.end());
        guard_.after_write(*entry_);
        return abort_code::none;
    }
    if (bytes_.size() != entry_->size) {
        return abort_code::wrong_length;
    }
    const std::int64_t value = value_from_bytes(bytes_.data(), entry_->size, entry_->is_signed);
    if (value < entry_->low || value > entry_->high) {
        return abort_code::value_range;
    }
    if (const std::uint32_t code = guard_.before_write(*entry_, value); code != abort_code::none) {
        return code;
    }
    entry_->value = value;
    guard_.after_write(*entry_);
    return abort_code::none;
}

} // namespace gonio::sim
