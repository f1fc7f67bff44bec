// The matrices H and N: their entries against a dense sum over the elements, their rows, blocks and
// rigid-body modes. Needs petsc_main.cpp.

#include <limits>
#include <map>
#include <vector>

#include "body.hpp"
#include "filter/filter.hpp"
#include "tet4_support.hpp"

namespace trefoil::test {
namespace {

INSTANTIATE_TEST_SUITE_P(Scenes, SceneTest, testing::ValuesIn(scenes),
                         [](const auto &each) { return std::string(each.param.name); });

/// The whole body once more on every rank, as dense sums over the elements of the mesher's list.
class Reference {
 public:
  explicit Reference(const CellList &mesh)
      : mesh_(mesh), size_(static_cast<std::size_t>(3 * mesh.vertices())) {
    H.assign(size_ * size_, 0);
    N.assign(size_ * size_, 0);
    for (std::size_t v = 0; 3 * v < size_; ++v) number_[position(&mesh.coordinates[3 * v])] = v;
    for (std::size_t c = 0; c < mesh.cells.size(); c += 4) add_cell(c);
  }

  std::vector<double> H, N;
  int indefinite = 0;

  /// Row and column of component i at a rest position.
  [[nodiscard]] std::size_t row(const double *p, int i) const {
    return 3 * number_.at(position(p)) + static_cast<std::size_t>(i);
  }
  [[nodiscard]] std::size_t size() const { return size_; }

 private:
  static std::array<double, 3> position(const double *p) { return {p[0], p[1], p[2]}; }

  void add_cell(std::size_t c) {
    double corner[4][3], u[12], He[144], Ne[144];
    std::size_t rows[12];
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t i = 0; i < 3; ++i) {
        rows[3 * a + i] = static_cast<std::size_t>(3 * mesh_.cells[c + a]) + i;
        corner[a][i] = mesh_.coordinates[rows[3 * a + i]];
      }
    for (std::size_t p = 0; p < 12; ++p) u[p] = crumpled(corner[p / 3], static_cast<int>(p % 3));
    const Tet4 tet = Tet4::at_rest(corner);
    Tangent<double> A;
    soft_material().tangent(Deformation(tet.displacement_gradient(u)), A);
    tet.hessian(A, He);
    EXPECT_EQ(split(12, 1, He, Ne, nullptr).status, SplitStatus::ok);
    for (std::size_t p = 0; p < 12; ++p)
      for (std::size_t q = 0; q < 12; ++q) {
        H[rows[p] * size_ + rows[q]] += He[12 * p + q];
        N[rows[p] * size_ + rows[q]] += Ne[12 * p + q];
      }
    indefinite += Ne[0] != 0;
  }

  const CellList &mesh_;
  std::size_t size_;
  std::map<std::array<double, 3>, std::size_t> number_;
};

/// Where a matrix's rows and columns stand in the reference.
std::vector<std::size_t> rows_in(const Reference &reference, const Body &body) {
  std::vector<PetscInt> row(static_cast<std::size_t>(body.discretization.total_dofs()), 0);
  const Mesh &mesh = body.mesh;
  for (std::size_t v = 0; v < mesh.owned.size(); ++v)
    for (std::size_t i = 0; mesh.owned[v] && i < 3; ++i) {
      const PetscInt dof = body.discretization.global_dofs()[3 * v + i];
      if (dof >= 0)
        row[static_cast<std::size_t>(dof)] =
            static_cast<PetscInt>(reference.row(&mesh.coordinates[3 * v], static_cast<int>(i)));
    }
  MPI_Allreduce(MPI_IN_PLACE, row.data(), static_cast<int>(row.size()), MPIU_INT, MPI_SUM,
                PETSC_COMM_WORLD);
  return {row.begin(), row.end()};
}

void expect_entries(Mat matrix, const std::vector<double> &dense, const Reference &reference,
                    const std::vector<std::size_t> &rows) {
  PetscInt begin = 0, end = 0;
  ASSERT_EQ(MatGetOwnershipRange(matrix, &begin, &end), PETSC_SUCCESS);
  const auto n = static_cast<PetscInt>(rows.size());
  for (PetscInt i = begin; i < end; ++i)
    for (PetscInt j = 0; j < n; ++j) {
      PetscScalar value = 0;
      ASSERT_EQ(MatGetValues(matrix, 1, &i, 1, &j, &value), PETSC_SUCCESS);
      ASSERT_NEAR(value,
                  dense[rows[static_cast<std::size_t>(i)] * reference.size() +
                        rows[static_cast<std::size_t>(j)]],
                  1e-12)
          << i << ' ' << j;
    }
}

TEST_P(SceneTest, HessianAndNegativePartAreTheSumsOverTheElements) {
  if (GetParam().mesh != std::string("box")) GTEST_SKIP() << "too large for dense matrices";
  const CellList whole = generate_mesh("box", 2, 0);
  ASSERT_EQ(body_.set_up(PETSC_COMM_WORLD, whole, GetParam().holding), PETSC_SUCCESS);
  const Reference reference(whole);
  const std::vector<std::size_t> rows = rows_in(reference, body_);
  OwnedVec x, rest;
  OwnedMat H, N;
  ASSERT_EQ(body_.vector(crumpled, &x), PETSC_SUCCESS);
  ASSERT_EQ(body_.vector(at_rest, &rest), PETSC_SUCCESS);
  ASSERT_EQ(body_.discretization.create_matrix(&H), PETSC_SUCCESS);
  // N is made in the first round and filled anew in the others.
  for (Vec state : {Vec(x), Vec(rest), Vec(x)}) {
    TrefoilSplitStatistics statistics{};
    ASSERT_EQ(body_.functional->hessian(state, H, &N, &statistics), PETSC_SUCCESS);
    ASSERT_NE(N.object, nullptr);
    if (state == rest.object) continue;
    expect_entries(H, reference.H, reference, rows);
    expect_entries(N, reference.N, reference, rows);
    PetscInt64 counts[2] = {statistics.elements, statistics.indefinite};
    MPI_Allreduce(MPI_IN_PLACE, counts, 2, MPIU_INT64, MPI_SUM, PETSC_COMM_WORLD);
    EXPECT_EQ(counts[0], whole.size());
    EXPECT_EQ(counts[1], reference.indefinite);
  }
  MatInfo info;
  ASSERT_EQ(MatGetInfo(H, MAT_GLOBAL_SUM, &info), PETSC_SUCCESS);
  EXPECT_EQ(info.mallocs, 0);  // room for every entry was made beforehand
  TrefoilSplitStatistics unfiltered{};
  ASSERT_EQ(body_.functional->hessian(x, H, nullptr, &unfiltered), PETSC_SUCCESS);
  expect_entries(H, reference.H, reference, rows);
  EXPECT_EQ(unfiltered.filter_seconds, 0);
}

TEST_P(SceneTest, HeldRowsAreAbsentAndBlocksAsDocumented) {
  ASSERT_EQ(body_.set_up(PETSC_COMM_WORLD, mesh(), GetParam().holding), PETSC_SUCCESS);
  const CellList whole = mesh();
  PetscInt free_components = 0;
  for (std::size_t k = 0; k < whole.coordinates.size(); ++k)
    free_components += !GetParam().holding(&whole.coordinates[k - k % 3], static_cast<int>(k % 3));
  OwnedMat H;
  PetscInt rows = 0, columns = 0, block_size = 0;
  ASSERT_EQ(body_.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(MatGetSize(H, &rows, &columns), PETSC_SUCCESS);
  ASSERT_EQ(MatGetBlockSize(H, &block_size), PETSC_SUCCESS);
  EXPECT_EQ(rows, free_components);
  EXPECT_EQ(columns, free_components);
  EXPECT_EQ(body_.discretization.total_dofs(), free_components);
  EXPECT_EQ(block_size, GetParam().block_size);
  EXPECT_EQ(body_.discretization.block_size(), GetParam().block_size);
  for (std::size_t dof = 0; dof < body_.held.held.size(); ++dof)
    EXPECT_EQ(body_.discretization.global_dofs()[dof] < 0, body_.held.held[dof] != 0);
}

TEST_P(SceneTest, SixRigidModesAreAttached) {
  ASSERT_EQ(body_.set_up(PETSC_COMM_WORLD, mesh(), GetParam().holding), PETSC_SUCCESS);
  OwnedMat H;
  OwnedVec rest, product;
  MatNullSpace space = nullptr;
  PetscInt count = 0;
  const Vec *modes = nullptr;
  PetscReal size = 0;
  TrefoilSplitStatistics statistics{};
  ASSERT_EQ(body_.discretization.create_matrix(&H), PETSC_SUCCESS);
  ASSERT_EQ(MatGetNearNullSpace(H, &space), PETSC_SUCCESS);
  ASSERT_NE(space, nullptr);
  ASSERT_EQ(MatNullSpaceGetVecs(space, nullptr, &count, &modes), PETSC_SUCCESS);
  ASSERT_EQ(count, 6);
  for (int m = 0; m < 6; ++m)
    for (int k = 0; k <= m; ++k) {
      PetscScalar overlap = 0;
      ASSERT_EQ(VecDot(modes[m], modes[k], &overlap), PETSC_SUCCESS);
      EXPECT_NEAR(overlap, m == k, 1e-12);
    }
  if (GetParam().name != std::string("free_box")) return;
  // With nothing held and nothing moved they cost no energy, and nothing else is free of cost.
  ASSERT_EQ(body_.vector(at_rest, &rest), PETSC_SUCCESS);
  ASSERT_EQ(VecDuplicate(rest, &product), PETSC_SUCCESS);
  ASSERT_EQ(body_.functional->hessian(rest, H, nullptr, &statistics), PETSC_SUCCESS);
  PetscReal largest = 0;
  ASSERT_EQ(MatNorm(H, NORM_FROBENIUS, &largest), PETSC_SUCCESS);
  for (int m = 0; m < 6; ++m) {
    ASSERT_EQ(MatMult(H, modes[m], product), PETSC_SUCCESS);
    ASSERT_EQ(VecNorm(product, NORM_2, &size), PETSC_SUCCESS);
    EXPECT_LT(size, 1e-13 * largest) << m;
  }
  const std::array<double, 3> centre{0.3, -1, 2};  // any centre will do
  for (int m = 0; m < 6; ++m) {
    OwnedVec mode;
    ASSERT_EQ(body_.vector([&](const double *p, int i) { return rigid_body_mode(m, i, p, centre); },
                           &mode),
              PETSC_SUCCESS);
    ASSERT_EQ(MatMult(H, mode, product), PETSC_SUCCESS);
    ASSERT_EQ(VecNorm(product, NORM_2, &size), PETSC_SUCCESS);
    EXPECT_LT(size, 1e-12 * largest) << m;
  }
}

/// Whoever holds too much: all ranks have to know, before anything is allocated.
TEST(MatrixSizeTest, WhatAPetscIntCannotCountIsRefusedOnAllRanks) {
  PetscMPIInt rank = 0, ranks = 1;
  MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  const PetscInt64 most = PETSC_MAX_INT;
  EXPECT_EQ(check_matrix_size(PETSC_COMM_WORLD, most), PETSC_SUCCESS);
  if (most == std::numeric_limits<PetscInt64>::max()) return;  // with 64-bit indices all fits
  ASSERT_EQ(PetscPushErrorHandler(PetscReturnErrorHandler, nullptr), PETSC_SUCCESS);
  EXPECT_EQ(check_matrix_size(PETSC_COMM_WORLD, rank == ranks - 1 ? most + 1 : 5),
            PETSC_ERR_USER_INPUT);
  ASSERT_EQ(PetscPopErrorHandler(), PETSC_SUCCESS);
}

}  // namespace
}  // namespace trefoil::test
