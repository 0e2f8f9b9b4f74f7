#include "slam/semantics/taxonomy.h"

#include <gtest/gtest.h>

namespace semmap {
namespace {

TEST(TaxonomyTest, NamesAreFoundInAnyCaseAndAreUnique) {
  for (size_t id = 0; id < kSemanticClasses.size(); ++id)
    EXPECT_EQ(FindSemanticClass(kSemanticClasses[id].name), id) << kSemanticClasses[id].name;
  EXPECT_EQ(FindSemanticClass("roadline"), 6);
  EXPECT_EQ(FindSemanticClass("Car"), std::nullopt);
  EXPECT_EQ(FindSemanticClass(""), std::nullopt);
}

TEST(TaxonomyTest, ColoursAreUnique) {
  for (size_t a = 0; a < kSemanticClasses.size(); ++a) {
    for (size_t b = 0; b < a; ++b)
      EXPECT_NE(kSemanticClasses[a].rgb, kSemanticClasses[b].rgb) << a << " " << b;
  }
}

TEST(TaxonomyTest, InactiveClassesAreThePapers) {
  const ClassSet inactive(kInactiveClasses);
  for (const char* name : {"Unlabeled", "Other", "Pedestrian", "Vehicles", "Sky", "Dynamic"})
    EXPECT_TRUE(inactive.Contains(*FindSemanticClass(name))) << name;
  for (const char* name : {"Building", "Road", "Static", "TrafficLight"})
    EXPECT_FALSE(inactive.Contains(*FindSemanticClass(name))) << name;
  EXPECT_FALSE(inactive.Contains(kUnknownClass));
  EXPECT_TRUE(ClassSet().empty());
  EXPECT_FALSE(inactive.empty());
}

}  // namespace
}  // namespace semmap
