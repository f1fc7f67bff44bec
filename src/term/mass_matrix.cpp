#include "term/mass_matrix.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "element/mass_matrix.hpp"

namespace trefoil {

MassMatrix::MassMatrix(const Mesh &mesh, std::vector<double> density_of_cell, MassKind kind)
    : mesh_(mesh), density_of_cell_(std::move(density_of_cell)), kind_(kind) {
  const auto nodes = static_cast<std::size_t>(mesh.nodes_per_cell());
  find_rows();
  value_.assign(column_.size(), 0);
  std::vector<double> M(nodes * nodes);
  for (PetscInt c = 0; c < mesh.local_cells(); ++c) {
    const PetscInt *node = &mesh.cells[nodes * static_cast<std::size_t>(c)];
    of_cell(c, M.data());
    for (std::size_t a = 0; a < nodes; ++a) {
      const auto row = static_cast<std::size_t>(node[a]);
      const auto begin = column_.begin() + static_cast<std::ptrdiff_t>(start_[row]);
      const auto end = column_.begin() + static_cast<std::ptrdiff_t>(start_[row + 1]);
      for (std::size_t b = 0; b < nodes; ++b) {
        if (kind == MassKind::lumped && a != b) continue;
        const auto at = std::lower_bound(begin, end, node[b]);
        value_[static_cast<std::size_t>(at - column_.begin())] += M[nodes * a + b];
      }
    }
  }
}

/// The neighbours of each vertex, itself included, in ascending order.
void MassMatrix::find_rows() {
  const auto vertices = static_cast<std::size_t>(mesh_.local_vertices());
  const auto nodes = static_cast<std::size_t>(mesh_.nodes_per_cell());
  start_.assign(vertices + 1, 0);
  if (kind_ == MassKind::lumped) {
    std::iota(start_.begin(), start_.end(), std::size_t{0});
    column_.resize(vertices);
    std::iota(column_.begin(), column_.end(), PetscInt{0});
    return;
  }
  std::vector<std::size_t> first_cell(vertices + 1, 0);
  for (const PetscInt v : mesh_.cells) ++first_cell[static_cast<std::size_t>(v) + 1];
  std::partial_sum(first_cell.begin(), first_cell.end(), first_cell.begin());
  std::vector<std::size_t> cells(mesh_.cells.size()), next(first_cell);
  for (std::size_t k = 0; k < mesh_.cells.size(); ++k) {
    cells[next[static_cast<std::size_t>(mesh_.cells[k])]++] = k / nodes;
  }
  std::vector<PetscInt> seen_by(vertices, -1);
  for (std::size_t v = 0; v < vertices; ++v) {
    for (std::size_t k = first_cell[v]; k < first_cell[v + 1]; ++k) {
      for (std::size_t a = 0; a < nodes; ++a) {
        const PetscInt w = mesh_.cells[nodes * cells[k] + a];
        PetscInt &last = seen_by[static_cast<std::size_t>(w)];
        if (last == static_cast<PetscInt>(v)) continue;
        last = static_cast<PetscInt>(v);
        column_.push_back(w);
      }
    }
    std::sort(column_.begin() + static_cast<std::ptrdiff_t>(start_[v]), column_.end());
    start_[v + 1] = column_.size();
  }
}

void MassMatrix::of_cell(PetscInt cell, double *M) const {
  const auto nodes = static_cast<std::size_t>(mesh_.nodes_per_cell());
  const auto c = static_cast<std::size_t>(cell);
  double positions[3 * ReferenceElement::most_nodes];
  for (std::size_t a = 0; a < nodes; ++a) {
    const auto v = static_cast<std::size_t>(mesh_.cells[nodes * c + a]);
    std::copy_n(&mesh_.coordinates[3 * v], 3, positions + 3 * a);
  }
  mass_matrix(reference_element(mesh_.dimension(), mesh_.nodes_per_cell()), positions, M);
  for (std::size_t k = 0; k < nodes * nodes; ++k) M[k] *= density_of_cell_[c];
  if (kind_ == MassKind::consistent) return;
  for (std::size_t a = 0; a < nodes; ++a) {
    double *row = M + nodes * a;
    const double sum = std::accumulate(row, row + nodes, 0.);
    std::fill_n(row, nodes, 0);
    row[a] = sum;
  }
}

void MassMatrix::add_product(double factor, const double *w, double *result) const {
  for (std::size_t v = 0; v + 1 < start_.size(); ++v) {
    double sum[3] = {};
    for (std::size_t k = start_[v]; k < start_[v + 1]; ++k) {
      const double *neighbour = w + 3 * column_[k];
      for (int i = 0; i < 3; ++i) sum[i] += value_[k] * neighbour[i];
    }
    for (std::size_t i = 0; i < 3; ++i) result[3 * v + i] += factor * sum[i];
  }
}

double MassMatrix::bytes() const {
  return static_cast<double>(start_.capacity() * sizeof(std::size_t) +
                             column_.capacity() * sizeof(PetscInt) +
                             (value_.capacity() + density_of_cell_.capacity()) * sizeof(double));
}

double dot(const std::vector<double> &a, const std::vector<double> &b) {
  return std::inner_product(a.begin(), a.end(), b.begin(), 0.);
}

}  // namespace trefoil
