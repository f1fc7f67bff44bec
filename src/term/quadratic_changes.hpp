#pragma once

#include <functional>
#include <vector>

namespace trefoil {

/// Adds to changes[p] what the energy w'Kw / 2 changes by along sum_k c_k d_k, for each of `points`
/// rows c of coefficients: one product with K for each direction is enough for all points.
/// @param product K times a local array
/// @param Kw gradient of the energy at w, this rank's part
void add_quadratic_changes(
    const std::function<std::vector<double>(const std::vector<double> &)> &product,
    const std::vector<double> &Kw, int directions, const double *const *d, int points,
    const double *coefficients, double *changes);

}  // namespace trefoil
