// bernstein.hpp: the first root of a polynomial on [0, 1] that suits the caller, from its Bernstein coefficients.
//
// The coefficients' changes of sign are at least the number of roots (Descartes), so: none, no root; one, one root,
// which Newton's method finds within a bracket; more, halve (de Casteljau). Sums of neighbours only, no cancellation,
// and no root that is a change of sign is ever missed (Lane & Riesenfeld 1981, "Bounds on a polynomial").
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace gonio::sim {

template <std::size_t count> struct Bernstein {
    std::array<double, count> coefficients; // degree: count - 1

    struct Value {
        double value;
        double slope;
    };
    [[nodiscard]] Value at(double x) const {
        std::array<double, count> c = coefficients;
        for (std::size_t left = count - 1; left > 1; --left) {
            for (std::size_t i = 0; i < left; ++i) {
                c[i] += x * (c[i + 1] - c[i]);
            }
        }
        return {c[0] + x * (c[1] - c[0]), static_cast<double>(count - 1) * (c[1] - c[0])};
    }

    [[nodiscard]] int sign_changes() const {
        int changes = 0;
        for (std::size_t i = 1; i < count; ++i) {
            changes += static_cast<int>((coefficients[i] < 0.0) != (coefficients[i - 1] < 0.0));
        }
        return changes;
    }

    // Makes this the left half and returns the right one.
    Bernstein halve() {
        Bernstein right;
        std::array<double, count> c = coefficients;
        for (std::size_t level = 0; level < count; ++level) {
            coefficients[level] = c[0];
            right.coefficients[count - 1 - level] = c[count - 1 - level];
            for (std::size_t i = 0; i + level + 1 < count; ++i) {
                c[i] = 0.5 * (c[i] + c[i + 1]);
            }
        }
        return right;
    }

    // The root between 0 and 1, whose values differ in sign (0 counts as positive). Newton's steps may run in a circle:
    // then halving ends it.
    [[nodiscard]] double bracketed_root() const {
        constexpr int newton_steps = 16;
        bool const falls = coefficients[count - 1] < 0.0;
        double low = 0.0;
        double high = 1.0;
        double x = coefficients[0] / (coefficients[0] - coefficients[count - 1]);
        x = x > 0.0 && x < 1.0 ? x : 0.5;
        for (int step = 0; step < 100; ++step) {
            auto const [value, slope] = at(x);
            ((value < 0.0) == falls ? high : low) = x;
            double next = x - value / slope;
            bool const settled = std::abs(next - x) <= 1e-15;
            if (high - low <= 1e-15) {
                break;
            }
            if (!settled && (step >= newton_steps || !(next > low && next < high))) {
                next = 0.5 * (low + high);
            }
            x = next;
            if (settled) {
                break;
            }
        }
        return x;
    }
};

// Calls accept(root) for the roots in ascending order until it says true; whether it did. Two roots nearer than 2^-40
// (a touch, to the precision of the coefficients) count as none.
template <std::size_t count, class Accept> bool first_root(const Bernstein<count> &polynomial, Accept accept) {
    struct Part {
        Bernstein<count> polynomial;
        double begin;
        double width;
    };
    if (polynomial.sign_changes() == 0) {
        return false;
    }
    constexpr std::size_t depth = 40;
    std::array<Part, depth + 2> parts;
    std::size_t waiting = 1;
    parts[0] = {polynomial, 0.0, 1.0};
    while (waiting > 0) {
        Part &part = parts[waiting - 1];
        int const changes = part.polynomial.sign_changes();
        if (changes == 0 || (part.width <= 0x1p-40 && changes % 2 == 0)) {
            --waiting;
        } else if (changes == 1 || part.width <= 0x1p-40) {
            double const root = part.begin + part.width * part.polynomial.bracketed_root();
            --waiting;
            if (accept(root)) {
                return true;
            }
        } else {
            part.width *= 0.5;
            Bernstein<count> const left = part.polynomial;
            Part first{left, part.begin, part.width};
            part.polynomial = first.polynomial.halve();
            part.begin += part.width;
            parts[waiting++] = first;
        }
    }
    return false;
}

// A polynomial whose root at 0 is known (coefficient 0 is nothing but rounding), divided by x.
template <std::size_t count> Bernstein<count - 1> without_root_at_0(const Bernstein<count> &polynomial) {
    Bernstein<count - 1> rest;
    for (std::size_t i = 1; i < count; ++i) {
        rest.coefficients[i - 1] =
            polynomial.coefficients[i] * (static_cast<double>(count - 1) / static_cast<double>(i));
    }
    return rest;
}

} // namespace gonio::sim
