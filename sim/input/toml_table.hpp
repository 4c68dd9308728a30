// toml_table.hpp: reading a TOML table strictly: every key is asked for, and one that is left over is an error with its
// file.
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include <toml++/toml.h>

namespace gonio::sim {

// What is wrong with a file that the user gave; one line.
class Input_error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

inline toml::table parse_toml_file(const std::filesystem::path &path) {
    if (!std::filesystem::is_regular_file(path)) {
        throw Input_error(path.string() + ": no such file");
    }
    try {
        return toml::parse_file(path.string());
    } catch (const toml::parse_error &error) {
        throw Input_error(path.string() + ": line " + std::to_string(error.source().begin.line) + ": " +
                          std::string(error.description()));
    }
}

class Toml_table {
public:
    // `where` names the file and, within it, the table.
    Toml_table(const toml::table &table, std::string where) : table_(table), where_(std::move(where)) {}

    [[nodiscard]] const std::string &where() const { return where_; }
    [[nodiscard]] bool has(const std::string &key) const { return table_.contains(key); }
    // Of which kind the value is, where several are allowed.
    [[nodiscard]] bool is_table(const std::string &key) const { return table_[key].is_table(); }
    [[nodiscard]] bool is_list(const std::string &key) const { return table_[key].is_array(); }

    double number(const std::string &key, double fallback) {
        auto const *node = find(key);
        return node == nullptr ? fallback : number_of(*node, key);
    }
    double number(const std::string &key) { return number_of(required(key), key); }
    std::int64_t integer(const std::string &key, std::int64_t fallback) {
        auto const *node = find(key);
        return node == nullptr ? fallback : typed<std::int64_t>(*node, key, "a whole number");
    }
    std::int64_t integer(const std::string &key) { return typed<std::int64_t>(required(key), key, "a whole number"); }
    bool boolean(const std::string &key, bool fallback) {
        auto const *node = find(key);
        if (node != nullptr && !node->is_boolean()) {
            fail(key, "must be true or false");
        }
        return node == nullptr ? fallback : **node->as_boolean();
    }
    std::string text(const std::string &key, const std::string &fallback) {
        auto const *node = find(key);
        return node == nullptr ? fallback : typed<std::string>(*node, key, "a text");
    }
    std::string text(const std::string &key) { return typed<std::string>(required(key), key, "a text"); }
    // A list of `count` numbers, or one number for all.
    template <std::size_t count> std::array<double, count> numbers(const std::string &key, double fallback) {
        std::array<double, count> values{};
        values.fill(fallback);
        auto const *node = find(key);
        if (node == nullptr) {
            return values;
        }
        if (auto const *list = node->as_array(); list != nullptr) {
            if (list->size() != count) {
                fail(key, "needs " + std::to_string(count) + " numbers");
            }
            for (std::size_t i = 0; i < count; ++i) {
                values.at(i) = number_of(*list->get(i), key);
            }
        } else {
            values.fill(number_of(*node, key));
        }
        return values;
    }
    std::vector<std::string> texts(const std::string &key) {
        std::vector<std::string> values;
        if (auto const *node = find(key); node != nullptr) {
            auto const *list = node->as_array();
            if (list == nullptr) {
                fail(key, "must be a list");
            }
            for (const toml::node &element : *list) {
                values.push_back(typed<std::string>(element, key, "a list of texts"));
            }
        }
        return values;
    }
    // A list of `count` times true or false; all false if it is not there.
    template <std::size_t count> std::array<bool, count> booleans(const std::string &key) {
        std::array<bool, count> values{};
        if (auto const *node = find(key); node != nullptr) {
            auto const *list = node->as_array();
            if (list == nullptr || list->size() != count) {
                fail(key, "needs " + std::to_string(count) + " times true or false");
            }
            for (std::size_t i = 0; i < count; ++i) {
                values.at(i) = typed<bool>(*list->get(i), key, "a list of true or false");
            }
        }
        return values;
    }
    // The table of that name, empty if there is none.
    Toml_table table(const std::string &key) {
        static const toml::table empty;
        auto const *node = find(key);
        if (node != nullptr && !node->is_table()) {
            fail(key, "must be a table");
        }
        return {node == nullptr ? empty : *node->as_table(), where_ + " [" + key + "]"};
    }
    // The tables of a list of tables.
    std::vector<Toml_table> tables(const std::string &key) {
        std::vector<Toml_table> found;
        auto const *node = find(key);
        if (node == nullptr) {
            return found;
        }
        auto const *list = node->as_array();
        if (list == nullptr) {
            fail(key, "must be a list of tables");
        }
        for (const toml::node &element : *list) {
            if (!element.is_table()) {
                fail(key, "must be a list of tables");
            }
            found.emplace_back(*element.as_table(), where_ + " [" + key + " " + std::to_string(found.size() + 1) + "]");
        }
        return found;
    }
    // Keys that are allowed here and mean nothing to the twin.
    void ignore(std::initializer_list<const char *> keys) { asked_.insert(keys.begin(), keys.end()); }
    // To be called last: refuses what nobody asked for.
    void finish(const std::string &what = "is not a key of this table; remove it or correct its spelling") const {
        for (const auto &[key, value] : table_) {
            if (asked_.count(std::string(key.str())) == 0) {
                fail(std::string(key.str()), what);
            }
        }
    }
    [[noreturn]] void fail(const std::string &key, const std::string &what) const {
        throw Input_error(where_ + ": '" + key + "' " + what);
    }

private:
    const toml::node *find(const std::string &key) {
        asked_.insert(key);
        return table_.get(key);
    }
    const toml::node &required(const std::string &key) {
        auto const *node = find(key);
        if (node == nullptr) {
            fail(key, "is missing");
        }
        return *node;
    }
    double number_of(const toml::node &node, const std::string &key) const {
        auto const value = typed<double>(node, key, "a number");
        if (!std::isfinite(value)) {
            fail(key, "must be a finite number");
        }
        return value;
    }
    template <typename T> T typed(const toml::node &node, const std::string &key, const std::string &kind) const {
        auto const value = node.value<T>();
        if (!value) {
            fail(key, "must be " + kind);
        }
        return *value;
    }

    const toml::table &table_;
    std::string where_;
    std::set<std::string> asked_;
};

} // namespace gonio::sim
