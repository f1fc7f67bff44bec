// What a host sets by functions, and the one table of the options. Needs petsc_main.cpp.

#include <fstream>
#include <sstream>

#include "plugin_fixture.hpp"
#include "snes/solver_options.hpp"

namespace trefoil::test {
namespace {

nlohmann::json iterations_of(const Host &host) {
  nlohmann::json history = host.history();
  for (auto &entry : history) entry.erase("seconds");
  return history;
}

TEST(SettersTest, DoWhatTheOptionsDo) {
  Host by_options("options_"), by_functions("functions_");
  for (Host *host : {&by_options, &by_functions}) host->option("snes_rtol", "0");
  by_options.option("snes_trefoil_filter", "blend");
  by_options.option("snes_trefoil_rho_tolerance", "0.05");
  by_options.option("snes_trefoil_search", "subspace");
  by_options.option("snes_trefoil_trust_start", "true");
  by_options.option("snes_trefoil_energy_tolerance", "1e-6");
  by_options.option("snes_trefoil_verify_minimum", "true");
  ASSERT_EQ(by_options.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(by_functions.set_up(), PETSC_SUCCESS);
  const SNES snes = by_functions.snes;
  ASSERT_EQ(TrefoilSNESSetFilter(snes, "blend"), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetRhoTolerance(snes, 0.05), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetSearch(snes, TREFOIL_SEARCH_SUBSPACE), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetTrustStart(snes, PETSC_TRUE), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetTolerances(snes, PETSC_DEFAULT, 1e-6), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetVerifyMinimum(snes, PETSC_TRUE), PETSC_SUCCESS);
  ASSERT_EQ(SNESSetFromOptions(snes), PETSC_SUCCESS);
  for (Host *host : {&by_options, &by_functions})
    ASSERT_EQ(host->solve(concave_start(host->chain)), PETSC_SUCCESS);
  EXPECT_EQ(iterations_of(by_functions), iterations_of(by_options));
  EXPECT_EQ(by_functions.record.at("solver").at("filter"), "blend");
  EXPECT_EQ(by_functions.record.at("result").at("minimum"), true);
}

TEST(SettersTest, AnOptionWins) {
  Host host;
  host.option("snes_trefoil_filter", "clamp");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetFilter(host.snes, "constant"), PETSC_SUCCESS);
  ASSERT_EQ(TrefoilSNESSetConstantWeight(host.snes, 0.75), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.history()[0].at("weight"), 0.75);
  ASSERT_EQ(SNESSetFromOptions(host.snes), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.history()[0].at("weight"), 0.5);
}

TEST(SettersTest, RefuseWhatTheOptionsRefuse) {
  Host host;
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  const QuietErrors quiet;
  EXPECT_NE(TrefoilSNESSetFilter(host.snes, "clmap"), PETSC_SUCCESS);
  EXPECT_NE(TrefoilSNESSetRhoTolerance(host.snes, -1), PETSC_SUCCESS);
  EXPECT_NE(TrefoilSNESSetConstantWeight(host.snes, std::nan("")), PETSC_SUCCESS);
  EXPECT_NE(TrefoilSNESSetTolerances(host.snes, -1, PETSC_DEFAULT), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  EXPECT_EQ(host.record.at("solver").at("filter"), "newton_first");
}

TEST(IndefiniteTest, IsSaidOfRulesThatMayLeaveTheHessianSo) {
  struct Row {
    const char *filter, *weight, *type;
    PetscBool may;
  };
  for (const Row &row :
       {Row{"adaptive", "", "trefoil", PETSC_FALSE}, Row{"tikhonov", "", "trefoil", PETSC_FALSE},
        Row{"newton", "", "trefoil", PETSC_TRUE}, Row{"on_demand", "", "trefoil", PETSC_TRUE},
        Row{"three_state", "", "trefoil", PETSC_TRUE},
        Row{"newton_first", "", "trefoil", PETSC_TRUE},
        Row{"multiplicative", "", "trefoil", PETSC_TRUE},
        Row{"constant", "0.5", "trefoil", PETSC_FALSE},
        Row{"constant", "0.4", "trefoil", PETSC_TRUE}, Row{"adaptive", "", "newtonls", PETSC_FALSE},
        Row{"adaptive", "", "newtontr", PETSC_TRUE}}) {
    Host host;
    PetscBool may = PETSC_FALSE;
    host.option("snes_trefoil_filter", row.filter);
    if (row.weight[0]) host.option("snes_trefoil_weight", row.weight);
    host.option("snes_type", row.type);
    if (row.type == std::string("newtonls")) host.option("snes_linesearch_type", "trefoil");
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(TrefoilSNESJacobianMayBeIndefinite(host.snes, &may), PETSC_SUCCESS);
    EXPECT_EQ(may, row.may) << row.filter << ' ' << row.weight << ' ' << row.type;
  }
}

TEST(IdleTest, AnOptionWithoutEffectIsSaidAndNoError) {
  struct Row {
    const char *filter, *search, *option, *value;
    bool idle;
  };
  for (const Row &row : {Row{"adaptive", "armijo", "corrections", "3", true},
                         Row{"adaptive", "armijo", "correction_gain", "0.1", true},
                         Row{"adaptive", "armijo", "trust_start", "true", true},
                         Row{"adaptive", "subspace", "corrections", "3", false},
                         Row{"adaptive", "armijo", "rho_tolerance", "0.1", false},
                         Row{"clamp", "armijo", "rho_tolerance", "0.1", true},
                         Row{"clamp", "subspace", "rho_tolerance", "0.1", false},
                         Row{"absolute", "armijo", "energy_tolerance", "1e-6", false}}) {
    Host host;
    const std::string name = std::string("snes_trefoil_") + row.option;
    host.option("snes_trefoil_filter", row.filter);
    host.option("snes_trefoil_search", row.search);
    host.option(name, row.value);
    ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
    ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
    const auto &notes = host.record.at("solver").at("notes");
    ASSERT_EQ(notes.size(), row.idle ? 1U : 0U) << row.filter << ' ' << row.search << ' ' << name;
    if (row.idle) {
      EXPECT_EQ(notes[0].get<std::string>().rfind("-chain_" + name + " has no effect", 0), 0U);
    }
  }
}

TEST(FactorisationsTest, AreCounted) {
  Host host;
  host.option("snes_trefoil_search", "subspace");
  host.option("snes_trefoil_trust_start", "true");
  ASSERT_EQ(host.set_up(), PETSC_SUCCESS);
  ASSERT_EQ(host.solve(concave_start(host.chain)), PETSC_SUCCESS);
  const auto &result = host.record.at("result");
  EXPECT_EQ(result.at("factorisations"), host.chain.calls.size());
  EXPECT_GT(result.at("linear_solves"), result.at("factorisations"));  // Shamanskii steps have none
}

// PETSc's manual pages are made from comments, so the list there is a copy of the table's.
TEST(OptionTableTest, TheManualPageHasIt) {
  std::ifstream file(LINE_SEARCH_SOURCE);
  std::string page;
  for (std::string word; file >> word;) page += word + ' ';  // however its lines are broken
  std::istringstream table(manual_of_options());
  int lines = 0;
  for (std::string line; std::getline(table, line); ++lines)
    EXPECT_NE(page.find(' ' + line + ' '), std::string::npos) << line;
  EXPECT_GE(lines, 18);
}

}  // namespace
}  // namespace trefoil::test
