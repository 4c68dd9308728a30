// scatter_table_file.cpp: strict reader of the text form of a Scatter_table; the format is in tabulated.hpp.
#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>

#include "tabulated.hpp"
#include "toml_table.hpp"

namespace gonio::sim {
namespace {

constexpr std::uint32_t most_cells = 1024;

class Table_lines {
public:
    explicit Table_lines(const std::filesystem::path &path) : path_(path), file_(path) {
        if (!std::filesystem::is_regular_file(path) || !file_) {
            throw Input_error(path.string() + ": no such file");
        }
    }
    // Words of the next line that has any; empty at the end.
    std::vector<std::string> next() {
        std::string line;
        std::vector<std::string> words;
        while (words.empty() && std::getline(file_, line)) {
            ++number_;
            line.resize(std::min(line.find('#'), line.size()));
            for (std::size_t at = 0; (at = line.find_first_not_of(" \t\r", at)) != std::string::npos;) {
                std::size_t const end = std::min(line.find_first_of(" \t\r", at), line.size());
                words.push_back(line.substr(at, end - at));
                at = end;
            }
        }
        return words;
    }
    [[noreturn]] void fail(const std::string &what) const {
        throw Input_error(path_.string() + ": line " + std::to_string(number_) + ": " + what);
    }
    [[nodiscard]] double number(const std::string &word) const {
        double value = 0.0;
        auto const [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size()) {
            fail("'" + word + "' is not a number");
        }
        return value;
    }
    // The one word after the keyword.
    std::string setting(const std::string &keyword) {
        std::vector<std::string> const words = next();
        if (words.size() != 2 || words[0] != keyword) {
            fail("expected '" + keyword + "' and its value");
        }
        return words[1];
    }

private:
    std::filesystem::path path_;
    std::ifstream file_;
    std::size_t number_ = 0;
};

Scatter_table::Follow follow_of(const std::string &word, const Table_lines &lines) {
    using Follow = Scatter_table::Follow;
    constexpr std::array<std::pair<const char *, Follow>, 4> known{
        {{"none", Follow::none}, {"mirror", Follow::mirror}, {"retro", Follow::retro}, {"through", Follow::through}}};
    for (const auto &[name, follow] : known) {
        if (word == name) {
            return follow;
        }
    }
    lines.fail("'follow' is none, mirror, retro or through");
}

std::vector<double> read_cells(Table_lines &lines, std::uint32_t cells) {
    std::vector<double> values;
    values.reserve(std::size_t{cells} * cells);
    for (std::uint32_t row = 0; row < cells; ++row) {
        std::vector<std::string> const words = lines.next();
        if (words.size() != cells) {
            lines.fail("needs " + std::to_string(cells) + " numbers, has " + std::to_string(words.size()));
        }
        for (const std::string &word : words) {
            values.push_back(lines.number(word));
        }
    }
    return values;
}

} // namespace

Scatter_table load_scatter_table(const std::filesystem::path &path) {
    Table_lines lines(path);
    if (lines.setting("gonio-scatter-table") != "1") {
        lines.fail("only version 1 is known");
    }
    Scatter_table table;
    double const cells = lines.number(lines.setting("cells"));
    if (!(cells >= 1.0 && cells <= most_cells) || cells != static_cast<double>(static_cast<std::uint32_t>(cells))) {
        lines.fail("'cells' is a whole number from 1 to " + std::to_string(most_cells));
    }
    table.cells = static_cast<std::uint32_t>(cells);
    table.follow = follow_of(lines.setting("follow"), lines);
    std::string const isotropic = lines.setting("isotropic");
    if (isotropic != "yes" && isotropic != "no") {
        lines.fail("'isotropic' is yes or no");
    }
    table.isotropic = isotropic == "yes";
    for (std::vector<std::string> words = lines.next(); !words.empty(); words = lines.next()) {
        if (words.size() != 4 || (words[0] != "front" && words[0] != "back") ||
            (words[3] != "reflected" && words[3] != "transmitted")) {
            lines.fail("expected side, theta, phi and part, as in: front 30 0 reflected");
        }
        std::vector<Scatter_table::Distribution> &side = words[0] == "front" ? table.front : table.back;
        double const theta_deg = lines.number(words[1]);
        double const phi_deg = lines.number(words[2]);
        auto found = std::find_if(side.begin(), side.end(), [&](const Scatter_table::Distribution &known) {
            return known.theta_deg == theta_deg && known.phi_deg == phi_deg;
        });
        if (found == side.end()) {
            side.push_back({theta_deg, phi_deg, {}, {}});
            found = side.end() - 1;
        }
        std::vector<double> &values = words[3] == "reflected" ? found->reflected : found->transmitted;
        if (!values.empty()) {
            lines.fail("the same direction and part a second time");
        }
        values = read_cells(lines, table.cells);
    }
    if (table.front.empty()) {
        lines.fail("no incident direction on the front");
    }
    return table;
}

} // namespace gonio::sim
