// photon_scenario.cpp: reads the parts of a scenario file that the photon map is concerned with; docs/scenarios.md has
// the keys.
#include "photon_scenario.hpp"

#include <cmath>
#include <utility>

#include "beam_reader.hpp"
#include "sample_parts.hpp"
#include "sample_reader.hpp"

namespace gonio::sim {
namespace {

// The file as it is kept for building samples anew: they refer to all of it.
struct Document {
    std::filesystem::path path;
    toml::table root;
    std::map<std::string, Scatter_table> tables;

    [[nodiscard]] Material_context context(const Band &band) const {
        return {band.name, band.wavelength_nm, tables, path.parent_path()};
    }
};

std::uint64_t count_of(Toml_table &table, const std::string &key, std::int64_t fallback, std::int64_t least) {
    std::int64_t const value = table.integer(key, fallback);
    if (value < least) {
        table.fail(key, "must be at least " + std::to_string(least));
    }
    return static_cast<std::uint64_t>(value);
}

// The few numbers of the instrument file that the photons see; the twin and the host check the rest of it.
void read_instrument(const std::filesystem::path &path, Receiver_settings &receiver) {
    toml::table const root = parse_toml_file(path);
    Toml_table file(root, path.string());
    Toml_table instrument = file.table("instrument");
    receiver.radius_mm = positive(instrument, "arm_radius_mm");
    receiver.aperture_mm = positive(instrument, "detector_aperture_mm");
    if (receiver.aperture_mm >= receiver.radius_mm) {
        instrument.fail("detector_aperture_mm", "must be below arm_radius_mm");
    }
}

void read_photons(Toml_table table, Photon_scenario &scenario) {
    scenario.photons = count_of(table, "count", 1000000, 1);
    if (scenario.photons > 1000000000000) {
        table.fail("count", "must be at most 1000000000000");
    }
    scenario.relative_error = within(table, "relative_error", 0.0, 0.0, 1.0);
    scenario.most_photons = count_of(table, "most_photons", 0, 0);
    if (table.has("most_photons") && scenario.relative_error == 0.0) {
        table.fail("most_photons", "needs relative_error; without it `count` photons are traced");
    }
    if (scenario.most_photons != 0 && scenario.most_photons < scenario.photons) {
        table.fail("most_photons", "must be at least count");
    }
    Trace_settings &trace = scenario.trace;
    trace.low_discrepancy = table.boolean("low_discrepancy", trace.low_discrepancy);
    trace.polarised = table.boolean("polarised", trace.polarised);
    trace.roulette_below = within(table, "roulette_below", trace.roulette_below, 0.0, 1.0);
    std::uint64_t const interactions = count_of(table, "most_interactions", trace.most_interactions, 1);
    if (interactions > 1000000000) {
        table.fail("most_interactions", "must be at most 1000000000");
    }
    trace.most_interactions = static_cast<std::uint32_t>(interactions);
    table.finish();
}

std::vector<Incident> read_incidents(const toml::table &root, Toml_table &table) {
    table.ignore({"incident"});
    std::vector<Incident> incidents;
    toml::node_view<const toml::node> const list = root["readings"]["incident"];
    if (!list) {
        return {{0.0, 0.0}};
    }
    if (!list.is_array() || list.as_array()->empty()) {
        table.fail("incident", "must be a list of directions [theta, phi] in degrees");
    }
    for (const toml::node &element : *list.as_array()) {
        auto const *pair = element.as_array();
        if (pair == nullptr || pair->size() != 2 || !pair->get(0)->is_number() || !pair->get(1)->is_number()) {
            table.fail("incident", "must be a list of directions [theta, phi] in degrees");
        }
        Incident const incident{*pair->get(0)->value<double>(), *pair->get(1)->value<double>()};
        if (!(incident.theta_deg >= 0.0 && incident.theta_deg <= 180.0 && std::abs(incident.phi_deg) <= 360.0)) {
            table.fail("incident", "must have theta from 0 to 180 and phi from -360 to 360");
        }
        incidents.push_back(incident);
    }
    return incidents;
}

void read_readings(const toml::table &root, Toml_table table, Photon_scenario &scenario) {
    scenario.incidents = read_incidents(root, table);
    scenario.direction_step_deg = within(table, "step_deg", scenario.direction_step_deg, 0.05, 45.0);
    Receiver_settings &receiver = scenario.receiver;
    receiver.acceptance_deg = within(table, "acceptance_deg", receiver.acceptance_deg, 0.1, 180.0);
    static const std::map<std::string, Estimator> estimators = {
        {"fixed", Estimator::fixed}, {"nearest", Estimator::nearest}, {"progressive", Estimator::progressive}};
    auto const estimator = estimators.find(table.text("estimator", "fixed"));
    if (estimator == estimators.end()) {
        table.fail("estimator", "must be fixed, nearest or progressive");
    }
    receiver.estimator = estimator->second;
    std::uint64_t const bandwidth = count_of(table, "bandwidth", receiver.bandwidth, 2);
    if (bandwidth > 100000000) {
        table.fail("bandwidth", "must be at most 100000000");
    }
    if (table.has("bandwidth") && receiver.estimator != Estimator::nearest) {
        table.fail("bandwidth", "needs estimator = \"nearest\"");
    }
    receiver.bandwidth = static_cast<std::uint32_t>(bandwidth);
    table.finish();
}

std::vector<Band> read_bands(std::vector<Toml_table> tables) {
    std::vector<Band> bands;
    for (Toml_table &table : tables) {
        Band band{table.text("name"), within(table, "wavelength_nm", 550.0, 100.0, 100000.0)};
        for (const Band &other : bands) {
            if (other.name == band.name) {
                table.fail("name", "is there twice");
            }
        }
        table.finish();
        bands.push_back(std::move(band));
    }
    if (bands.empty()) {
        bands.push_back({"visible", 550.0});
    }
    return bands;
}

void read_rig(Toml_table table) {
    // The holder is read with the sample; head and splitters are the rig's.
    table.ignore({"holder", "head", "splitters"});
    table.finish();
}

void set_makers(const std::shared_ptr<const Document> &document, const Source_settings &source,
                Photon_scenario &scenario) {
    scenario.sample = [document](const Band &band, bool mounted) {
        return mounted ? read_sample(document->root, document->path.string(), document->context(band)) : free_beam();
    };
    scenario.source = [source](const Band & /*band*/) { return std::make_unique<Beam_source>(source); };
    for (const Band &band : scenario.bands) {
        scenario.sample(band, true);
        scenario.source(band);
    }
}

} // namespace

Photon_scenario load_photon_scenario(const std::filesystem::path &path, const std::filesystem::path &source_directory,
                                     const std::map<std::string, Scatter_table> &tables) {
    auto const document = std::make_shared<const Document>(Document{path, parse_toml_file(path), tables});
    Toml_table table(document->root, path.string());
    Photon_scenario scenario{};
    scenario.path = path;
    scenario.trace.seed = count_of(table, "seed", 1, 0);
    std::filesystem::path instrument = path.parent_path() / table.text("instrument", "axes.toml");
    if (!table.has("instrument") && !std::filesystem::exists(instrument)) {
        instrument = source_directory / "protocol" / "axes.toml";
    }
    read_instrument(instrument, scenario.receiver);
    scenario.trace.receiver_radius_mm = scenario.receiver.radius_mm;
    scenario.bands = read_bands(table.tables("band"));
    read_photons(table.table("photons"), scenario);
    read_readings(document->root, table.table("readings"), scenario);
    read_rig(table.table("rig"));
    Source_settings const source = read_beam(table.table("beam"), table.table("source"), scenario.receiver.radius_mm);
    Stokes const &light = source.stokes;
    bool const carried = scenario.trace.polarised || table.table("rig").has("splitters"); // these need Stokes vectors
    if (!carried && (light.q != 0.0 || light.u != 0.0 || light.v != 0.0)) {
        table.table("photons").fail("polarised", "must be true: without it the polarisation of [source] has no effect");
    }
    Toml_table sample = table.table("sample");
    sample.boolean("mounted", true);
    table.ignore({"materials", "detector", "timing", "drives", "fault"});
    table.finish();
    set_makers(document, source, scenario);
    return scenario;
}

} // namespace gonio::sim
