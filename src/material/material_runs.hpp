#pragma once

#include <petscsystypes.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <vector>

#include "trefoil/material_model.hpp"

namespace trefoil {

/// The materials of one rank's cells, as the kernels want them: runs of packs, eight cells each, of
/// one MaterialModel. A pack whose cells have several materials makes a run of its own, whose model
/// asks each of them and takes from each the lanes that are its own.
class MaterialRuns {
 public:
  /// One material for all cells.
  MaterialRuns(std::unique_ptr<MaterialModel> material, PetscInt cells);
  /// @param material_of_cell for each cell a position in `materials`
  MaterialRuns(std::vector<std::unique_ptr<MaterialModel>> materials,
               std::vector<int> material_of_cell);

  struct Run {
    PetscInt first = 0, count = 0;  ///< packs
    const MaterialModel *material = nullptr;
  };

  /// Calls visit(run) for the runs that make up packs [first, first + count), in order.
  template <class Visit>
  void for_each_run(PetscInt first, PetscInt count, Visit visit) const {
    for (Run run : runs_) {
      const PetscInt end = std::min(run.first + run.count, first + count);
      run.first = std::max(run.first, first);
      run.count = end - run.first;
      if (run.count > 0) visit(run);
    }
  }
  [[nodiscard]] const std::vector<Run> &runs() const { return runs_; }

  /// The same cells with other materials, made by the stiffness of each.
  [[nodiscard]] MaterialRuns by_stiffness(
      const std::function<std::unique_ptr<MaterialModel>(double stiffness)> &make) const;

  /// What a cell is made of.
  [[nodiscard]] const MaterialModel &of_cell(PetscInt cell) const {
    return *materials_[position_of(cell)];
  }
  /// Mean of the diagonal of dP/dF at rest: the stiffness of a cell's material, force per area.
  [[nodiscard]] double stiffness_of(PetscInt cell) const { return stiffness_[position_of(cell)]; }
  [[nodiscard]] double bytes() const;

 private:
  [[nodiscard]] std::size_t position_of(PetscInt cell) const {
    return material_of_cell_.empty()
               ? 0
               : static_cast<std::size_t>(material_of_cell_[static_cast<std::size_t>(cell)]);
  }
  void find_stiffnesses();
  void make_runs();

  std::vector<std::unique_ptr<MaterialModel>> materials_;
  PetscInt cells_ = 0;
  std::vector<int> material_of_cell_;  ///< empty: all have the first
  std::vector<double> stiffness_;
  std::vector<std::shared_ptr<const MaterialModel>> mixed_;
  std::vector<Run> runs_;
};

}  // namespace trefoil
