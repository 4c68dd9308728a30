// progressive.cpp: averages batches, each weighted by its photons.
#include "progressive.hpp"

#include <cmath>
#include <numbers>

#include "elementary.hpp"

namespace gonio::sim {

namespace {

double half_angle_of(double solid_angle_sr) {
    double const half_sine2 = solid_angle_sr / (4.0 * std::numbers::pi);
    return 2.0 * arc_tangent(std::sqrt(half_sine2), std::sqrt(1.0 - half_sine2));
}

} // namespace

Progressive_readings::Progressive_readings(std::span<const Vector> directions, double first_half_angle_rad,
                                           double alpha)
    : directions_(directions.begin(), directions.end()), half_angle_rad_(first_half_angle_rad),
      last_half_angle_rad_(first_half_angle_rad), alpha_(alpha), means_(directions.size()) {}

void Progressive_readings::add(const Hit_map &batch, unsigned threads) {
    Aperture_sums const sums = batch.sums(directions_, half_angle_rad_, threads);
    double const number = static_cast<double>(batch.photons());
    for (std::size_t i = 0; i < means_.size(); ++i) {
        Estimate const value = estimate(sums.weight[i], sums.square[i], sums.hits[i], batch.photons(), half_angle_rad_);
        double const error = number * value.standard_error_per_sr;
        means_[i].dsf += number * value.dsf_per_sr;
        means_[i].variance += error * error;
        means_[i].hits += value.hits;
    }
    photons_ += number;
    batches_ += 1.0;
    last_half_angle_rad_ = half_angle_rad_;
    half_angle_rad_ = half_angle_of(cap_sr(half_angle_rad_) * (batches_ + alpha_) / (batches_ + 1.0));
}

std::vector<Estimate> Progressive_readings::estimates() const {
    std::vector<Estimate> result;
    result.reserve(means_.size());
    for (const Mean &mean : means_) {
        result.push_back(photons_ > 0.0 ? Estimate{mean.dsf / photons_, std::sqrt(mean.variance) / photons_,
                                                   last_half_angle_rad_, mean.hits}
                                        : Estimate{});
    }
    return result;
}

} // namespace gonio::sim
