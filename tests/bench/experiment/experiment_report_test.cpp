#include "tests/bench/experiment/experiment_report.h"

#include <gmock/gmock.h>

#include "tests/bench/experiment/variant.h"

namespace semmap::bench {
namespace {

using ::testing::HasSubstr;

VariantResult Result(const std::string& route, uint64_t seed, const std::string& variant,
                     std::optional<double> mape, int run = 1) {
  VariantResult result;
  result.route = route;
  result.traffic_seed = seed;
  result.run = run;
  result.variant = variant;
  result.frames = 100;
  result.tracked = 90;
  result.duration_s = 5;
  result.length_m = 50;
  result.mape_percent = mape;
  if (mape) result.ate_m = *mape / 10;
  result.census.all.points = result.census.active.points = 1000;
  result.census.active.on_traffic_vehicles = 25;
  result.census.classes[1] = {10, 9, 40, 30};
  return result;
}

TEST(SpreadTest, MeanAndSampleDeviation) {
  const Spread spread = SpreadOf({1, 2, 6});
  EXPECT_DOUBLE_EQ(spread.mean, 3);
  EXPECT_DOUBLE_EQ(spread.deviation, std::sqrt(7.0));
  EXPECT_EQ(spread.least, 1);
  EXPECT_EQ(spread.greatest, 6);
  EXPECT_EQ(SpreadOf({}).count, 0U);
  EXPECT_EQ(SpreadOf({4}).deviation, 0);
}

class ReportTest : public ::testing::Test {
 protected:
  const std::vector<std::string> variants_ = {"base", "paper"};
  std::vector<VariantResult> results_ = {Result("1", 1, "base", 10), Result("1", 2, "base", 30),
                                         Result("1", 1, "paper", 5), Result("1", 2, "paper", 25),
                                         Result("2", 1, "base", 2),  Result("2", 1, "paper", 1)};
};

TEST_F(ReportTest, ChangesAreOfTheMeansAndOfEachSeed) {
  const auto figures = Summarize(results_, variants_);
  ASSERT_EQ(figures.size(), 4U);
  EXPECT_EQ(figures[0].variant, "base");
  EXPECT_FALSE(figures[0].change_percent.has_value());
  EXPECT_DOUBLE_EQ(figures[0].mape_percent.mean, 20);
  EXPECT_DOUBLE_EQ(*figures[1].change_percent, -25);
  EXPECT_NEAR(figures[1].change_of_seeds_percent.mean, (-50 - 100.0 / 6) / 2, 1e-9);
  EXPECT_DOUBLE_EQ(*figures[3].change_percent, -50);
  EXPECT_DOUBLE_EQ(*MeanChange(figures, "paper"), -37.5);
  EXPECT_EQ(MeanChange(figures, "perfect"), std::nullopt);
}

TEST_F(ReportTest, SeedsThatOneSideFailedDoNotEnterTheChange) {
  results_.push_back(Result("2", 2, "base", std::nullopt));
  results_.push_back(Result("2", 2, "paper", 100));
  const auto figures = Summarize(results_, variants_);
  EXPECT_EQ(figures[2].tracked_share.count, 2U);
  EXPECT_EQ(figures[2].mape_percent.count, 1U);
  EXPECT_DOUBLE_EQ(*figures[3].change_percent, -50);
}

TEST_F(ReportTest, RunsAreComparedSeedBySeed) {
  results_.push_back(Result("2", 1, "base", 4, 2));
  results_.push_back(Result("2", 1, "paper", 8, 2));
  const auto figures = Summarize(results_, variants_);
  EXPECT_NEAR(*figures[3].change_percent, 50, 1e-9);  // (1 + 8) / (2 + 4)
  EXPECT_NEAR(figures[3].change_of_seeds_percent.mean, 25, 1e-9);
}

TEST_F(ReportTest, TextShowsTableSharesAndAccuracy) {
  const std::string text = ReportText(results_, variants_);
  EXPECT_THAT(text, HasSubstr("-25.0 %"));
  EXPECT_THAT(text, HasSubstr("20.00 +- 14.14"));
  EXPECT_THAT(text, HasSubstr("mean relative change of paper over the routes: -37.5 %"));
  EXPECT_THAT(text, HasSubstr("2.50 %"));   // on moving vehicles
  EXPECT_THAT(text, HasSubstr("90.00 %"));  // right by votes
  EXPECT_THAT(text, HasSubstr("75.00 %"));  // right labels
  const nlohmann::json json = ReportJson(results_, variants_);
  EXPECT_DOUBLE_EQ(json["mean_change_percent"]["paper"], -37.5);
  EXPECT_EQ(json["rows"].size(), 4U);
}

TEST(VariantResultTest, SurvivesJson) {
  VariantResult result = Result("3", 7, "paper", 1.5);
  result.frame = {3, 4};
  result.error_m = {0.5, 0.25};
  result.estimate = {{1, 2}, {3, 4}};
  const auto read = ResultFromJson(ToJson(result));
  ASSERT_TRUE(read.ok()) << read.status();
  EXPECT_EQ(ToJson(*read), ToJson(result));
  EXPECT_EQ(read->traffic_seed, 7U);
  EXPECT_EQ(read->census.classes[1].correct_labels, 30U);
  EXPECT_EQ(ResultFromJson(nlohmann::json::object()).status().code(), absl::StatusCode::kDataLoss);
  result.mape_percent.reset();
  EXPECT_FALSE(ResultFromJson(ToJson(result))->mape_percent.has_value());
}

TEST(VariantTest, SwitchesOneByOne) {
  EXPECT_FALSE(FindVariant("base")->Configure(SlamConfig()).semantics.enabled);
  const SemanticsConfig paper = FindVariant("paper")->Configure(SlamConfig()).semantics;
  EXPECT_TRUE(paper.enabled && paper.votes && paper.filter_inactive && !paper.strict);
  EXPECT_EQ(paper.penalty, 0.5);
  EXPECT_EQ(FindVariant("filter")->Configure(SlamConfig()).semantics.penalty, 0);
  EXPECT_FALSE(FindVariant("penalty")->Configure(SlamConfig()).semantics.filter_inactive);
  EXPECT_FALSE(FindVariant("perfect-first")->Configure(SlamConfig()).semantics.votes);
  EXPECT_TRUE(FindVariant("strict")->Configure(SlamConfig()).semantics.strict);
  EXPECT_EQ(FindVariant("perfect")->masks, MaskSource::kTruth);
  SlamConfig rims;
  rims.semantics.class_rim_px = 2;
  EXPECT_EQ(FindVariant("paper")->Configure(rims).semantics.class_rim_px, 0);
  EXPECT_EQ(FindVariant("semmap")->Configure(rims).semantics.class_rim_px, 2);
  EXPECT_EQ(paper.sky_rim_px, 0);
  EXPECT_GT(FindVariant("perfect-semmap")->Configure(SlamConfig()).semantics.sky_rim_px, 0);
  EXPECT_EQ(FindVariant("nonsense"), nullptr);
}

}  // namespace
}  // namespace semmap::bench
