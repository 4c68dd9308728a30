// rough_heights.cpp: white noise, smoothed by a Gaussian kernel along rows and columns.
//
// A kernel exp(-2 d^2 / l^2) makes the correlation exp(-d^2 / l^2) of length l (Garcia and Stoll 1984, "Monte Carlo
// calculation for electromagnetic-wave scattering from random rough surfaces"). The spline through the smoothed points
// lowers the variance by a known factor, which is made up for.
#include "rough_heights.hpp"

#include <cmath>

#include "placing.hpp"
#include "random.hpp"

namespace gonio::sim {
namespace {

constexpr double points_per_length = 4.0;
constexpr std::uint32_t flat_rim = 3; // control points

double square(double value) {
    return value * value;
}

// Correlation of control points that are `steps` apart.
double correlation(double steps) {
    return exponential(-square(steps / points_per_length));
}

// Mean variance of a quadratic B-spline over that of its control points, along one dimension: the autocorrelation of
// the basis function at whole steps is the quintic B-spline's 66, 26, 1 parts in 120.
double kept_variance() {
    return (66.0 + 52.0 * correlation(1.0) + 2.0 * correlation(2.0)) / 120.0;
}

// A Gaussian number of unit variance (Box and Muller 1958), one for each place.
double gaussian(std::uint64_t seed, std::uint64_t place) {
    Photon_random random(seed, place);
    double const radius = std::sqrt(-2.0 * logarithm(random.uniform()));
    return radius * sine_cosine_of_turns(random.uniform()).cosine;
}

std::vector<double> kernel() {
    auto const reach = static_cast<int>(2.0 * points_per_length);
    std::vector<double> weights;
    double sum_of_squares = 0.0;
    for (int step = -reach; step <= reach; ++step) {
        weights.push_back(exponential(-2.0 * square(step / points_per_length)));
        sum_of_squares += square(weights.back());
    }
    for (double &weight : weights) {
        weight /= std::sqrt(sum_of_squares);
    }
    return weights;
}

// Sums along each row, shorter by the kernel's length less 1.
std::vector<double> smoothed_rows(const std::vector<double> &noise, std::size_t rows, std::size_t columns,
                                  const std::vector<double> &weights) {
    std::size_t const width = columns - weights.size() + 1;
    std::vector<double> smooth(rows * width);
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t column = 0; column < width; ++column) {
            double sum = 0.0;
            for (std::size_t i = 0; i < weights.size(); ++i) {
                sum += weights[i] * noise[row * columns + column + i];
            }
            smooth[row * width + column] = sum;
        }
    }
    return smooth;
}

std::vector<double> turned(const std::vector<double> &grid, std::size_t rows, std::size_t columns) {
    std::vector<double> result(grid.size());
    for (std::size_t row = 0; row < rows; ++row) {
        for (std::size_t column = 0; column < columns; ++column) {
            result[column * rows + row] = grid[row * columns + column];
        }
    }
    return result;
}

std::uint32_t points(double length_mm, double correlation_mm) {
    return static_cast<std::uint32_t>(std::ceil(length_mm * points_per_length / correlation_mm)) + 2;
}

} // namespace

Height_field rough_face(const Vector &corner, const Frame &frame, double width, double depth,
                        const Roughness &roughness, std::uint32_t surface) {
    Height_field field{
        corner, frame,  width, depth, points(depth, roughness.correlation_mm), points(width, roughness.correlation_mm),
        {},     surface};
    std::vector<double> const weights = kernel();
    std::size_t const noise_rows = field.rows + weights.size() - 1;
    std::size_t const noise_columns = field.columns + weights.size() - 1;
    std::vector<double> noise(noise_rows * noise_columns);
    for (std::size_t place = 0; place < noise.size(); ++place) {
        noise[place] = gaussian(roughness.seed, place);
    }
    std::vector<double> const along = smoothed_rows(noise, noise_rows, noise_columns, weights);
    std::vector<double> const across =
        smoothed_rows(turned(along, noise_rows, field.columns), field.columns, noise_rows, weights);
    field.heights = turned(across, field.columns, field.rows);

    // The square root of the variances kept along two dimensions.
    double const scale = roughness.rms_mm / kept_variance();
    for (std::uint32_t row = 0; row < field.rows; ++row) {
        for (std::uint32_t column = 0; column < field.columns; ++column) {
            bool const rim = row < flat_rim || column < flat_rim || row + flat_rim >= field.rows ||
                             column + flat_rim >= field.columns;
            field.heights[row * field.columns + column] *= rim ? 0.0 : scale;
        }
    }
    return field;
}

} // namespace gonio::sim
