// net_folder.hpp: a folder like /sys/class/net, in which interfaces come and go as the test says.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

namespace gonio::test {

class Net_folder {
public:
    Net_folder() {
        std::string name = (std::filesystem::temp_directory_path() / "gonio-net-XXXXXX").string();
        path_ = mkdtemp(name.data());
    }
    Net_folder(const Net_folder &) = delete;
    Net_folder &operator=(const Net_folder &) = delete;
    ~Net_folder() { std::filesystem::remove_all(path_); }

    const char *path() const { return path_.c_str(); }
    void set(const std::string &name, int index, int type, unsigned flags) {
        std::filesystem::create_directories(path_ + "/" + name);
        write(name + "/ifindex", std::to_string(index));
        write(name + "/type", std::to_string(type));
        char text[16];
        (void)std::snprintf(text, sizeof text, "0x%x", flags);
        write(name + "/flags", text);
    }
    void remove(const std::string &name) { std::filesystem::remove_all(path_ + "/" + name); }

private:
    void write(const std::string &file, const std::string &text) { std::ofstream(path_ + "/" + file) << text << '\n'; }
    std::string path_;
};

constexpr int type_can = 280;    // ARPHRD_CAN
constexpr unsigned up = 0x40081; // NOARP, LOWER_UP, UP: as vcan0 shows
constexpr unsigned down = 0x40080;

} // namespace gonio::test
