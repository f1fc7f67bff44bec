// The choice of the linear solver, and the free memory that it goes by.

#include "scene/solver_choice.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "support/free_memory.hpp"

namespace trefoil::test {
namespace {

constexpr double gigabyte = 1e9;

/// Bodies of tests/benchmarks/large.py, with what the symbolic analysis says of them.
SolverTask box_48k() {
  return {.cells = 48000, .poisson = 0.495, .factor = {1.134e7, 5.25e9}, .free_bytes = 20e9};
}
SolverTask box_197k() {
  return {.cells = 196608, .poisson = 0.495, .factor = {8.21e7, 8.55e10}, .free_bytes = 20e9};
}
SolverTask horse_50k() {
  return {.cells = 50536, .poisson = 0.495, .factor = {4.68e6, 6.42e8}, .free_bytes = 20e9};
}
SolverTask on_two_ranks(SolverTask task) {
  task.ranks = 2;
  return task;
}

TEST(SolverChoiceTest, SlenderBodiesAreFactoredAndBulkyOnesAreNot) {
  EXPECT_EQ(choose_solver(horse_50k(), "auto").kind, SolverKind::direct);
  EXPECT_EQ(choose_solver(on_two_ranks(horse_50k()), "auto").kind, SolverKind::direct);
  EXPECT_EQ(choose_solver(on_two_ranks(box_48k()), "auto").kind, SolverKind::iterative);
  EXPECT_EQ(choose_solver(box_197k(), "auto").kind, SolverKind::iterative);
}

TEST(SolverChoiceTest, MemoryDecidesBeforeTime) {
  SolverTask task = horse_50k();
  task.free_bytes = 50e6;
  const SolverChoice choice = choose_solver(task, "auto");
  EXPECT_EQ(choice.kind, SolverKind::iterative);
  EXPECT_NE(choice.reason.find("would need about 49 MB of the 50 MB free"), std::string::npos)
      << choice.reason;
}

TEST(SolverChoiceTest, WhatIsNeededBesideTheSolverCounts) {
  SolverTask task = horse_50k();
  task.free_bytes = 0.1 * gigabyte;
  EXPECT_EQ(choose_solver(task, "auto").kind, SolverKind::direct);
  task.other_bytes = 0.05 * gigabyte;
  EXPECT_EQ(choose_solver(task, "auto").kind, SolverKind::iterative);
}

TEST(SolverChoiceTest, NearlyIncompressibleBodiesAreFactoredWhileThatFits) {
  SolverTask task = box_197k();
  task.poisson = 0.4999;
  const SolverChoice choice = choose_solver(task, "auto");
  EXPECT_EQ(choice.kind, SolverKind::direct);
  EXPECT_NE(choice.reason.find("0.4999"), std::string::npos) << choice.reason;
  task.free_bytes = 0.5 * gigabyte;
  EXPECT_EQ(choose_solver(task, "auto").kind, SolverKind::iterative);
}

TEST(SolverChoiceTest, MultigridTakesOnePressureAnElementWhateverPoissonsRatio) {
  const auto solver = [](const SolverTask &task) { return choose_solver(task, "auto").kind; };
  // Cubes of tet10, 10 cells an edge, and 12.
  SolverTask small = {.cells = 6000, .order = 2, .factor = {1.3e7, 6.7e9}, .free_bytes = 20e9};
  SolverTask large = {.cells = 10368, .order = 2, .factor = {2.78e7, 1.92e10}, .free_bytes = 20e9};
  for (SolverTask *task : {&small, &large}) {
    task->poisson = 0.45;
    EXPECT_EQ(solver(*task), SolverKind::iterative);
    task->poisson = 0.4999;
    EXPECT_EQ(solver(*task), SolverKind::direct);
    task->one_pressure = true;
  }
  EXPECT_EQ(solver(small), SolverKind::direct);
  EXPECT_EQ(solver(large), SolverKind::iterative);
}

/// The knot of 304 thousand cells: the model has multigrid ahead there, measurements the factors.
TEST(SolverChoiceTest, FactorsAreTakenWhereMultigridLooksLittleFaster) {
  const SolverTask task{
      .cells = 304128, .poisson = 0.495, .factor = {7.3e7, 3.7e10}, .free_bytes = 20e9};
  const double ratio = direct_seconds(task) / iterative_seconds(task);
  EXPECT_GT(ratio, 1);
  EXPECT_LT(ratio, 1.5);
  EXPECT_EQ(choose_solver(task, "auto").kind, SolverKind::direct);
}

TEST(SolverChoiceTest, WhereThereAreNoFactorsTheyAreNotTaken) {
  SolverTask task = on_two_ranks(horse_50k());
  task.can_factor = false;
  EXPECT_EQ(choose_solver(task, "auto").kind, SolverKind::iterative);
}

TEST(SolverChoiceTest, AWishIsGranted) {
  EXPECT_EQ(choose_solver(box_197k(), "direct").kind, SolverKind::direct);
  EXPECT_EQ(choose_solver(horse_50k(), "iterative").kind, SolverKind::iterative);
}

TEST(SolverChoiceTest, UnknownFreeMemoryIsEnough) {
  SolverTask task = horse_50k();
  task.free_bytes = INFINITY;
  const SolverChoice choice = choose_solver(task, "auto");
  EXPECT_EQ(choice.kind, SolverKind::direct);
  EXPECT_EQ(choice.reason.find("free"), std::string::npos) << choice.reason;
}

TEST(SolverChoiceTest, BytesAreReadable) {
  EXPECT_EQ(bytes_text(4.44e6), "4.4 MB");
  EXPECT_EQ(bytes_text(117.6e6), "118 MB");
  EXPECT_EQ(bytes_text(9.14e9), "9.1 GB");
  EXPECT_EQ(bytes_text(999.9e6), "1.0 GB");
}

/// A folder with the kernel's files, as the reader of free memory finds them.
class FreeMemoryTest : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove_all(root_); }
  void write(const std::string &path, const std::string &text) const {
    const std::filesystem::path file = root_ + path;
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
  }
  [[nodiscard]] double free_bytes() const { return free_bytes_of_machine(root_); }

  std::string root_ = ::testing::TempDir() + "free_memory_" +
                      ::testing::UnitTest::GetInstance()->current_test_info()->name() + "/";
};

TEST_F(FreeMemoryTest, IsWhatTheKernelCallsAvailable) {
  write("proc/meminfo", "MemTotal: 100 kB\nMemFree: 10 kB\nMemAvailable: 50 kB\n");
  EXPECT_EQ(free_bytes(), 50 * 1024.0);
}

TEST_F(FreeMemoryTest, IsUnlimitedWhereNothingIsKnown) {
  EXPECT_TRUE(std::isinf(free_bytes()));
}

TEST_F(FreeMemoryTest, ObeysControlGroupsAndThoseAboveThem) {
  write("proc/meminfo", "MemAvailable: 1000 kB\n");
  write("proc/self/cgroup", "0::/jobs/one\n");
  write("sys/fs/cgroup/jobs/one/memory.max", "max\n");
  write("sys/fs/cgroup/jobs/one/memory.current", "30000\n");
  EXPECT_EQ(free_bytes(), 1000 * 1024.0);
  write("sys/fs/cgroup/jobs/memory.max", "100000\n");
  write("sys/fs/cgroup/jobs/memory.current", "60000\n");
  EXPECT_EQ(free_bytes(), 40000);
  write("sys/fs/cgroup/jobs/memory.stat", "anon 40000\ninactive_file 20000\n");
  EXPECT_EQ(free_bytes(), 60000);  // the kernel gives up pages of files
}

TEST_F(FreeMemoryTest, FindsTheGroupOfAContainerWhoseOwnPathIsHidden) {
  write("proc/meminfo", "MemAvailable: 1000 kB\n");
  write("proc/self/cgroup", "0::/not/here\n");
  write("sys/fs/cgroup/memory.max", "100000\n");
  write("sys/fs/cgroup/memory.current", "90000\n");
  EXPECT_EQ(free_bytes(), 10000);
}

TEST_F(FreeMemoryTest, ObeysTheFirstVersionOfControlGroups) {
  write("proc/meminfo", "MemAvailable: 1000 kB\n");
  write("proc/self/cgroup", "5:cpu,cpuacct:/job\n4:memory:/job\n");
  write("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "100000\n");
  write("sys/fs/cgroup/memory/job/memory.usage_in_bytes", "70000\n");
  write("sys/fs/cgroup/memory/job/memory.stat", "total_inactive_file 5000\n");
  EXPECT_EQ(free_bytes(), 35000);
}

TEST_F(FreeMemoryTest, AGroupBeyondItsLimitHasNothingLeft) {
  write("proc/self/cgroup", "0::/\n");
  write("sys/fs/cgroup/memory.max", "100\n");
  write("sys/fs/cgroup/memory.current", "200\n");
  EXPECT_EQ(free_bytes(), 0);
}

}  // namespace
}  // namespace trefoil::test
