#include "scene/vertex_axes.hpp"

#include <algorithm>
#include <cmath>

namespace trefoil {
namespace {

double dot(const std::array<double, 3> &a, const std::array<double, 3> &b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// Fills the axes that are missing, in the plane the last with that out of it.
void complete_axes(int dimension, TurnedVertex *turned) {
  const int held = turned->held;
  std::vector<std::size_t> order{0, 1, 2};
  // Those first that lie least along the axes that there are.
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    double sums[2] = {};
    for (int k = 0; k < held; ++k) {
      sums[0] += std::pow(turned->axes[static_cast<std::size_t>(k)][a], 2);
      sums[1] += std::pow(turned->axes[static_cast<std::size_t>(k)][b], 2);
    }
    return sums[0] < sums[1];
  });
  const auto fill = [&](std::size_t i) {
    std::array<double, 3> axis{};
    axis[i] = 1;
    if (turned->held < 3) add_direction(axis, 0, -1, turned);
  };
  for (const std::size_t i : order) {
    if (dimension == 3 || i != 2) fill(i);
  }
  fill(2);
  turned->held = held;
}

}  // namespace

Direction add_direction(std::array<double, 3> direction, double value, int holder,
                        TurnedVertex *turned) {
  // Of a formula on a surface that a CAD kernel has made flat but for rounding; and what nobody
  // means to be two planes, whose line of intersection is anywhere.
  constexpr double same = 1e-6, similar = 1e-3;
  double largest = std::abs(value);
  for (int k = 0; k < turned->held; ++k) {
    const auto j = static_cast<std::size_t>(k);
    const double share = dot(direction, turned->axes[j]);
    for (std::size_t i = 0; i < 3; ++i) direction[i] -= share * turned->axes[j][i];
    value -= share * turned->values[j];
    largest = std::max(largest, std::abs(turned->values[j]));
  }
  const double length = std::sqrt(dot(direction, direction));
  if (length < same) {
    return std::abs(value) <= same * largest ? Direction::known : Direction::contradicts;
  }
  for (double &component : direction) component /= length;
  const auto next = static_cast<std::size_t>(turned->held++);
  turned->axes[next] = direction;
  turned->values[next] = value / length;
  turned->holder[next] = holder;
  return length < similar ? Direction::nearly_known : Direction::another;
}

TurnedVertex begin_turned(const HeldDofs &held, PetscInt v, const std::vector<int> &holder) {
  TurnedVertex turned{.vertex = v};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto dof = static_cast<std::size_t>(3 * v) + i;
    std::array<double, 3> axis{};
    axis[i] = 1;
    if (held.held[dof] && holder[dof] >= 0) {
      add_direction(axis, held.value[dof], holder[dof], &turned);
    }
  }
  return turned;
}

void settle_turned(int dimension, HeldDofs *held, std::vector<int> *holder) {
  std::vector<TurnedVertex> turned;
  for (TurnedVertex &one : held->turned) {
    const auto first = static_cast<std::size_t>(3 * one.vertex);
    bool along_space = true;
    for (std::size_t k = 0; k < static_cast<std::size_t>(one.held); ++k) {
      along_space = along_space && std::count(one.axes[k].begin(), one.axes[k].end(), 0.) == 2;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(dimension); ++i) {
      held->held[first + i] = 0;
      held->value[first + i] = 0;
      (*holder)[first + i] = -1;
      for (std::size_t k = 0; along_space && k < static_cast<std::size_t>(one.held); ++k) {
        if (one.axes[k][i] == 0) continue;
        held->held[first + i] = 1;
        held->value[first + i] = one.values[k] * one.axes[k][i];
        (*holder)[first + i] = one.holder[k];
      }
    }
    if (along_space) continue;
    complete_axes(dimension, &one);
    turned.push_back(one);
  }
  held->turned = std::move(turned);
}

}  // namespace trefoil
