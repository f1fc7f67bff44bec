#include "scene/solver_choice.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace trefoil {
namespace {

/// Solves with one Jacobian: the direction's and Shamanskii's.
constexpr double solves = 6;
/// How much faster than factors multigrid has to look on linear elements: slender bodies take more
/// iterations than the model knows (the knot of 304 thousand cells, which looks 1.3 times as fast
/// on one rank, takes 1.5 times as long), and factors also tell whether the end is a minimum.
constexpr double margin_of_linear = 1.5;
/// Of the memory that is free, what the solver may plan for.
constexpr double usable = 0.9;

/// Bytes for each number of the factor: CHOLMOD's supernodes hold 1.25 to 1.32 times the numbers of
/// the estimate; MUMPS, with its stack of fronts and a margin for it, up to 2.7.
double bytes_an_entry(int ranks) {
  return 8 * (ranks == 1 ? 1.3 : 3.0);
}

std::string times_text(double ratio) {
  char text[32];
  std::snprintf(text, sizeof text, ratio < 9.5 ? "%.1f" : "%.0f", ratio);
  return text;
}

std::string free_text(const SolverTask &task) {
  return std::isfinite(task.free_bytes) ? " of the " + bytes_text(task.free_bytes) + " free" : "";
}

}  // namespace

std::string bytes_text(double bytes) {
  const char *unit = "MB";
  double number = bytes / 1e6;
  if (number >= 999.5) {
    number /= 1e3;
    unit = "GB";
  }
  char text[32];
  std::snprintf(text, sizeof text, number < 9.95 ? "%.1f %s" : "%.0f %s", number, unit);
  return text;
}

double direct_seconds(const SolverTask &task) {
  // CHOLMOD on one rank; MUMPS, whose solves with two ranks are no faster.
  const double factor_rate = task.ranks == 1 ? 2.5e10 : 5.5e9 * task.ranks;
  const double seconds_an_entry = task.ranks == 1 ? 3.5e-9 : 4e-9;
  return task.factor.flops / factor_rate + solves * task.factor.entries * seconds_an_entry;
}

double iterative_seconds(const SolverTask &task) {
  // A set-up and thirty iterations of a cell, mostly in bandwidth that ranks share; quadratic cells
  // have sixteen times the entries of linear ones, and a set-up that is mostly the products of the
  // coarse level.
  const double seconds_a_cell = task.order == 1 ? 7.6e-6 : 45e-6;
  const double ranks = task.ranks == 1 ? 1 : 0.8 * task.ranks;
  const bool is_hard = task.one_pressure && task.poisson > most_poisson_for_multigrid;
  return (is_hard ? 2.4 : 1) * seconds_a_cell * static_cast<double>(task.cells) / ranks;
}

SolverChoice choose_solver(const SolverTask &task, const std::string &wish) {
  SolverChoice choice;
  const std::string cells = std::to_string(task.cells) + " " + task.cell;
  choice.factor_bytes = bytes_an_entry(task.ranks) * task.factor.entries;
  const std::string bytes = "about " + bytes_text(choice.factor_bytes);
  const double ratio = direct_seconds(task) / iterative_seconds(task);
  const bool fits = choice.factor_bytes + task.other_bytes <= usable * task.free_bytes;
  if (wish != "auto") {
    choice.kind = wish == "direct" ? SolverKind::direct : SolverKind::iterative;
    choice.reason = cells + ", as -solver says; a Cholesky factor needs " + bytes + free_text(task);
  } else if (!task.can_factor) {
    choice.kind = SolverKind::iterative;
    choice.reason = cells + "; this PETSc has no Cholesky factors on several ranks";
  } else if (!fits) {
    choice.kind = SolverKind::iterative;
    choice.reason = cells + "; a Cholesky factor would need " + bytes + free_text(task);
  } else if (ratio <= (task.order == 1 ? margin_of_linear : 1)) {
    choice.reason = cells + "; its factor needs " + bytes + free_text(task);
  } else if (task.poisson > most_poisson_for_multigrid && !task.one_pressure) {
    char poisson[32];
    std::snprintf(poisson, sizeof poisson, "%.6g", task.poisson);
    choice.reason = cells + ", and Poisson's ratio " + poisson +
                    " is too much for multigrid; its factor needs " + bytes + free_text(task);
  } else {
    choice.kind = SolverKind::iterative;
    choice.reason = cells + "; a Cholesky factor would take about " + times_text(ratio) +
                    " times as long, and " + bytes.substr(6);
  }
  return choice;
}

}  // namespace trefoil
