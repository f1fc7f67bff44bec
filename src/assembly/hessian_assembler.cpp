#include "assembly/hessian_assembler.hpp"

#include <algorithm>

#include "assembly/add_rows.hpp"
#include "assembly/stencil_assembler.hpp"
#include "support/petsc_compatibility.hpp"

namespace trefoil {
namespace {

/// What the N of a term is multiplied by so that its part of H + 2 w N is filtered by its weight.
double negative_factor(const Term &term, const HessianFilter *filter) {
  return filter && term.filter_weight() == FilterWeight::clamp ? 0.5 / filter->weight : 1;
}

PetscErrorCode end_assembly(Mat matrix) {
  PetscFunctionBeginUser;
  PetscCall(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  PetscCall(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace

HessianAssembler::~HessianAssembler() {
  for (Constant &constant : constants_) {
    static_cast<void>(MatDestroy(&constant.matrix));  // errors have nowhere to go from here
  }
  for (Mat &matrix : cells_) static_cast<void>(MatDestroy(&matrix));
}

bool HessianAssembler::goes_in_batches(const Term &term, const HessianFilter *filter) const {
  return term.hessian_kind() == HessianKind::packed && !one_by_one_ &&
         (!filter || filter->floor.share == 0);
}

bool HessianAssembler::filters_at_once() const {
  return std::all_of(terms_.begin(), terms_.end(), [this](const auto &term) {
    return (term->hessian_kind() == HessianKind::none || goes_in_batches(*term, nullptr)) &&
           !term->shifts_filter();
  });
}

PetscErrorCode HessianAssembler::add_product(const double *u, const double *p,
                                             double *product) const {
  PetscFunctionBeginUser;
  for (const auto &term : terms_) {
    if (term->hessian_kind() == HessianKind::none) continue;
    PetscCall(PackedAssembler::add_product(*term->batch(), u, p, product));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HessianAssembler::prepare(Mat H) {
  std::vector<const ElementPacks *> packs;
  PetscFunctionBeginUser;
  if (packed_->ready()) PetscFunctionReturn(PETSC_SUCCESS);
  for (const auto &term : terms_) {
    if (goes_in_batches(*term, nullptr)) packs.push_back(&term->batch()->elements());
  }
  if (!packs.empty()) PetscCall(packed_->set_up(discretization_, packs, H));
  PetscFunctionReturn(PETSC_SUCCESS);
}

void HessianAssembler::shift_filter(const ElementPacks &cells, PetscInt first, PetscInt count,
                                    double *K) const {
  for (const auto &term : terms_) {
    if (term->shifts_filter()) term->shift_filter(cells, first, count, K);
  }
}

/// Sets what goes in batches; other than that, zeros.
PetscErrorCode HessianAssembler::assemble_in_batches(const double *u, Mat H, Mat N,
                                                     const HessianFilter *filter,
                                                     TrefoilSplitStatistics *statistics) {
  std::vector<PackedAssembler::Part> parts;
  PackedAssembler::Shift shift;
  PetscFunctionBeginUser;
  for (const auto &term : terms_) {
    if (goes_in_batches(*term, filter)) {
      parts.push_back({term->batch(), negative_factor(*term, filter)});
    }
  }
  if (parts.empty()) {
    for (Mat matrix : {H, N}) {
      if (matrix) PetscCall(MatZeroEntries(matrix));
    }
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(prepare(H ? H : N));
  if (std::any_of(terms_.begin(), terms_.end(),
                  [](const auto &term) { return term->shifts_filter(); })) {
    shift = [this](const ElementPacks &cells, PetscInt first, PetscInt count, double *K) {
      shift_filter(cells, first, count, K);
    };
  }
  const double formed = filter && filter->at_once ? 2 * filter->weight : 0;
  PetscCall(packed_->assemble(parts, u, shift, {H, N, filter != nullptr, formed}, statistics));
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds to the matrix of a cell's element what shift_filter() adds to its reduced one.
void HessianAssembler::shift_stencil(const Term &term, const Stencil &stencil, double *H) const {
  const PackedElements *elements = term.batch();
  if (!elements || stencil.cell < 0) return;
  const ElementPacks &cells = elements->elements();
  const int nodes = cells.reference->nodes, dim = cells.reference->dimension;
  const PetscInt pack = stencil.cell / lanes, lane = stencil.cell % lanes;
  std::vector<double> K(static_cast<std::size_t>(cells.entries() * lanes), 0);
  std::vector<double> blocks(static_cast<std::size_t>(upper_blocks(nodes) * dim * dim * lanes));
  shift_filter(cells, pack, 1, K.data());
  elements->expand()(K.data(), blocks.data());
  /// Where a node of the pack stands in the stencil.
  const auto place = [&](int node) {
    const auto at = static_cast<std::size_t>((nodes * pack + node) * lanes + lane);
    int k = 0;
    while (stencil.dofs[dim * k] / 3 != cells.nodes[at]) ++k;
    return dim * k;
  };
  const double *entry = blocks.data() + lane;
  for (int a = 0; a < nodes; ++a) {
    for (int b = a; b < nodes; ++b) {
      for (int k = 0; k < dim * dim; ++k, entry += lanes) {
        const int row = place(a) + k / dim, column = place(b) + k % dim;
        H[stencil.n * row + column] += *entry;
        if (a != b) H[stencil.n * column + row] += *entry;
      }
    }
  }
}

/// Adds what goes one by one.
PetscErrorCode HessianAssembler::assemble_one_by_one(const double *u, Mat H, Mat N,
                                                     const HessianFilter *filter,
                                                     TrefoilSplitStatistics *statistics) const {
  const bool shifted = std::any_of(terms_.begin(), terms_.end(),
                                   [](const auto &term) { return term->shifts_filter(); });
  bool any = false;
  PetscFunctionBeginUser;
  for (const auto &term : terms_) {
    const HessianKind kind = term->hessian_kind();
    if (kind != HessianKind::stencils &&
        (kind != HessianKind::packed || goes_in_batches(*term, filter))) {
      continue;
    }
    any = true;
    StencilAssembler assembler(discretization_, H, N, statistics);
    assembler.set_filtering(filter != nullptr);
    assembler.set_negative_factor(negative_factor(*term, filter));
    if (filter) assembler.set_floor(filter->floor);
    if (shifted) {
      assembler.set_shift(
          [&](const Stencil &stencil, double *matrix) { shift_stencil(*term, stencil, matrix); });
    }
    PetscCall(term->add_hessian(u, assembler));
    PetscCall(assembler.flush());
  }
  for (Mat matrix : {H, N}) {
    if (any && matrix) PetscCall(end_assembly(matrix));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

/// Adds the constant matrices, each made when it is first needed, and anew when it has changed.
/// @param H with the pattern of the cells
PetscErrorCode HessianAssembler::add_constants(Mat H) {
  PetscFunctionBeginUser;
  for (const auto &term : terms_) {
    if (term->hessian_kind() != HessianKind::constant) continue;
    auto found = std::find_if(constants_.begin(), constants_.end(),
                              [&](const Constant &made) { return made.term == term.get(); });
    const bool is_new = found == constants_.end();
    if (is_new) {
      Mat matrix = nullptr;
      PetscCall(MatDuplicate(H, MAT_DO_NOT_COPY_VALUES, &matrix));
      found = constants_.insert(constants_.end(), {term.get(), matrix, 0});
    }
    if (is_new || found->version != term->hessian_version()) {
      TrefoilSplitStatistics ignored{};
      if (!is_new) PetscCall(MatZeroEntries(found->matrix));
      found->version = term->hessian_version();
      StencilAssembler assembler(discretization_, found->matrix, nullptr, &ignored);
      assembler.set_filtering(false);
      PetscCall(term->add_hessian(nullptr, assembler));
      PetscCall(assembler.flush());
      PetscCall(end_assembly(found->matrix));
    }
    PetscCall(MatAXPY(H, term->hessian_scale(), found->matrix, SAME_NONZERO_PATTERN));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HessianAssembler::assemble(const double *u, Mat H, Mat N,
                                          const HessianFilter *filter,
                                          TrefoilSplitStatistics *statistics) {
  const Mat wanted[2] = {H, N};
  Mat target[2] = {H, N};
  PetscFunctionBeginUser;
  for (int k = 0; has_pairs_ && k < 2; ++k) {
    if (wanted[k] && !cells_[k]) PetscCall(discretization_.create_matrix(&cells_[k]));
    if (wanted[k]) target[k] = cells_[k];
  }
  PetscCall(assemble_in_batches(u, target[0], target[1], filter, statistics));
  if (H) PetscCall(add_constants(target[0]));
  for (int k = 0; has_pairs_ && k < 2; ++k) {
    if (!wanted[k]) continue;
    PetscCall(MatZeroEntries(wanted[k]));
    PetscCall(add_rows(target[k], wanted[k]));
  }
  PetscCall(assemble_one_by_one(u, H, N, filter, statistics));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HessianAssembler::assemble_constants(Mat P) {
  PetscFunctionBeginUser;
  PetscCall(MatZeroEntries(P));
  if (!has_pairs_) {
    PetscCall(add_constants(P));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  PetscCall(MatZeroEntries(cells_[0]));
  PetscCall(add_constants(cells_[0]));
  PetscCall(add_rows(cells_[0], P));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HessianAssembler::update_pattern(const double *u, Mat H, Mat *N) {
  PetscMPIInt anew = 0;
  bool any = false;
  VertexPairs pairs;
  PetscFunctionBeginUser;
  for (const auto &term : terms_) {
    if (!term->couples_pairs()) continue;
    bool changed = false;
    PetscCall(term->choose_pairs(u, &changed));
    anew = anew || changed;
    any = true;
  }
  if (!any) PetscFunctionReturn(PETSC_SUCCESS);
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &anew, 1, MPI_INT, MPI_MAX,
                             PetscObjectComm(reinterpret_cast<PetscObject>(H))));
  if (anew || !has_pairs_) {
    if (!has_pairs_) PetscCall(prepare(H));  // while it has the cells' pattern
    for (const auto &term : terms_) {
      if (term->couples_pairs()) term->append_pairs(&pairs);
    }
    PetscCall(discretization_.set_pattern(pairs, H));
    has_pairs_ = true;
    fitting_negative_ = 0;
  }
  if (N && *N) {
    PetscObjectId id = 0;
    PetscCall(PetscObjectGetId(reinterpret_cast<PetscObject>(*N), &id));
    if (id != fitting_negative_) PetscCall(MatDestroy(N));
  }
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HessianAssembler::make_negative(Mat H, Mat *N) {
  PetscFunctionBeginUser;
  PetscCall(MatDuplicate(H, MAT_DO_NOT_COPY_VALUES, N));
  PetscCall(PetscObjectGetId(reinterpret_cast<PetscObject>(*N), &fitting_negative_));
  PetscFunctionReturn(PETSC_SUCCESS);
}

PetscErrorCode HessianAssembler::count_negative(const double *u,
                                                std::vector<double> *counts) const {
  const auto cells = std::find_if(terms_.begin(), terms_.end(),
                                  [](const auto &term) { return term->has_cells(); });
  PetscFunctionBeginUser;
  counts->clear();
  if (cells == terms_.end()) PetscFunctionReturn(PETSC_SUCCESS);
  if (!one_by_one_ && (*cells)->batch()) {
    PetscCall(PackedAssembler::count_negative(*(*cells)->batch(), u, counts));
    PetscFunctionReturn(PETSC_SUCCESS);
  }
  TrefoilSplitStatistics ignored{};
  StencilAssembler counter(discretization_, nullptr, nullptr, &ignored);
  counter.keep_counts(counts);
  PetscCall((*cells)->add_hessian(u, counter));
  PetscCall(counter.flush());
  PetscFunctionReturn(PETSC_SUCCESS);
}

}  // namespace trefoil
