// The main() of unit tests that use PETSc and run under mpirun. All ranks run the same tests; the
// run fails where any rank does.

#include <gtest/gtest.h>
#include <petscsys.h>

#include <cstdio>
#include <string>

namespace {

/// What ranks other than the first have to say: their failures, each with its rank.
class FailuresOfThisRank : public testing::EmptyTestEventListener {
 public:
  explicit FailuresOfThisRank(int rank) : rank_(rank) {}

  // Kept here, because GoogleTest holds its lock while it reports: asking it then never returns.
  void OnTestStart(const testing::TestInfo &test) override {
    test_ = std::string(test.test_suite_name()) + "." + test.name();
  }

  void OnTestPartResult(const testing::TestPartResult &result) override {
    if (!result.failed()) return;
    // One call a failure, so that the lines of different ranks do not mix.
    std::fprintf(stderr, "[rank %d] %s: %s:%d: Failure\n%s\n", rank_, test_.c_str(),
                 result.file_name() ? result.file_name() : "unknown file", result.line_number(),
                 result.message());
  }

 private:
  int rank_;
  std::string test_ = "outside a test";
};

void leave_progress_to_rank_0(int rank) {
  if (rank == 0) return;
  auto &listeners = testing::UnitTest::GetInstance()->listeners();
  delete listeners.Release(listeners.default_result_printer());
  delete listeners.Release(listeners.default_xml_generator());  // one report file, not one a rank
  listeners.Append(new FailuresOfThisRank(rank));               // GoogleTest owns it
}

}  // namespace

int main(int argc, char **argv) {
  testing::InitGoogleTest(&argc, argv);
  PetscCall(PetscInitialize(&argc, &argv, nullptr, nullptr));
  int rank = 0;
  PetscCallMPI(MPI_Comm_rank(PETSC_COMM_WORLD, &rank));
  leave_progress_to_rank_0(rank);

  int exit_code = RUN_ALL_TESTS();
  PetscCallMPI(MPI_Allreduce(MPI_IN_PLACE, &exit_code, 1, MPI_INT, MPI_MAX, PETSC_COMM_WORLD));
  PetscCall(PetscFinalize());
  return exit_code;
}
