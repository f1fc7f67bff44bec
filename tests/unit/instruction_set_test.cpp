// TREFOIL_SIMD is read in one place: names of instruction sets, those that this processor has.

#include "simd/instruction_set.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

namespace trefoil::test {
namespace {

/// The sentence for a value of TREFOIL_SIMD.
std::string error_with(const char *value) {
  setenv("TREFOIL_SIMD", value, 1);
  const std::string sentence = instruction_set_error();
  unsetenv("TREFOIL_SIMD");
  return sentence;
}

TEST(InstructionSetTest, NamesAreThoseThatTheProcessorHas) {
  unsetenv("TREFOIL_SIMD");
  EXPECT_EQ(instruction_set_error(), "");
  EXPECT_EQ(error_with(""), "");
  EXPECT_EQ(error_with("baseline"), "");
  EXPECT_EQ(error_with("avx2").empty(), processor_has(InstructionSet::avx2));
  EXPECT_EQ(error_with("avx512").empty(), processor_has(InstructionSet::avx512));
}

TEST(InstructionSetTest, AnUnknownNameIsToldTheKnownOnes) {
  for (const char *name : {"AVX2", "avx", "sse", "avx3", "none"}) {
    const std::string sentence = error_with(name);
    EXPECT_NE(sentence.find("TREFOIL_SIMD is '" + std::string(name) + "'"), std::string::npos);
    EXPECT_NE(sentence.find("baseline"), std::string::npos);
  }
}

TEST(InstructionSetTest, TheChosenOneIsThereAndStays) {
  const InstructionSet chosen = chosen_instruction_set();
  EXPECT_TRUE(processor_has(chosen));
  setenv("TREFOIL_SIMD", "baseline", 1);
  EXPECT_EQ(chosen_instruction_set(), chosen) << "kernels of two kinds would be mixed";
  unsetenv("TREFOIL_SIMD");
}

}  // namespace
}  // namespace trefoil::test
