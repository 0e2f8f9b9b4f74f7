// How well the index finds what exact search finds (FAISS): on synthetic places with a vocabulary learnt on
// other places, and with the vocabulary that ships on recorded streets, where they are there.
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "slam/features/orb_extractor.h"
#include "slam/place/place_index.h"
#include "slam/place/vocabulary_trainer.h"
#include "tests/support/place_oracle/place_oracle.h"
#include "tests/unit/place/place_test_util.h"

namespace semmap {
namespace {

using testing::Perturbed;

// Descriptors of real corners come in kinds. A place draws some, each with its own look.
class SyntheticWorld {
 public:
  std::vector<Descriptor> NewPlace(size_t corners) {
    std::vector<Descriptor> place;
    for (size_t i = 0; i < corners; ++i)
      place.push_back(Perturbed(kinds_[random_() % kinds_.size()], 60, random_));
    return place;
  }
  // Another view: some corners are lost, others new, the rest changed a little.
  std::vector<Descriptor> SeeAgain(const std::vector<Descriptor>& place) {
    std::vector<Descriptor> view = NewPlace(place.size() / 3);
    for (const Descriptor& corner : place) {
      if (random_() % 3 != 0) view.push_back(Perturbed(corner, 20, random_));
    }
    return view;
  }

 private:
  std::mt19937_64 random_{21};
  std::vector<Descriptor> kinds_ = testing::RandomDescriptors(300, random_);
};

TEST(PlaceRecall, FindsWhatExactSearchFinds) {
  SyntheticWorld world;
  std::vector<std::vector<Descriptor>> training;
  for (int i = 0; i < 100; ++i) training.push_back(world.NewPlace(150));
  VocabularyTrainingConfig config;
  config.levels = 3;
  const auto vocabulary = Vocabulary::FromTree(TrainVocabulary(training, config).value()).value();
  PlaceIndex index(vocabulary);
  testing::ExactPlaceOracle oracle;
  std::vector<std::vector<Descriptor>> places;
  for (uint64_t i = 0; i < 150; ++i) {
    places.push_back(world.NewPlace(150));
    oracle.Add(places.back());
    index.Add(KeyFrameId(i + 1), vocabulary->Describe(places.back()).words);
  }
  int exact_right = 0;
  int index_agrees = 0;
  for (size_t i = 0; i < places.size(); i += 3) {
    const auto view = world.SeeAgain(places[i]);
    const size_t exact = oracle.Rank(view)[0];
    exact_right += exact == i ? 1 : 0;
    const auto matches = index.Query(vocabulary->Describe(view).words, 1);
    index_agrees += !matches.empty() && matches[0].keyframe == KeyFrameId(exact + 1) ? 1 : 0;
  }
  EXPECT_EQ(exact_right, 50);
  EXPECT_GE(index_agrees, 48);
}

TEST(ExactPlaceOracle, VotesForTheNearest) {
  std::mt19937_64 random(1);
  testing::ExactPlaceOracle oracle;
  const auto first = testing::RandomDescriptors(5, random);
  const auto second = testing::RandomDescriptors(5, random);
  oracle.Add(first);
  oracle.Add(second);
  const std::vector<Descriptor> query = {first[0], second[1], Perturbed(second[2], 10, random)};
  EXPECT_EQ(oracle.Rank(query), (std::vector<size_t>{1, 0}));
}

TEST(ShippedVocabulary, IsWhatItsCardSays) {
  const auto vocabulary = Vocabulary::Load(DefaultVocabularyPath());
  ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
  EXPECT_EQ((*vocabulary)->words(), 65446U);
  EXPECT_EQ((*vocabulary)->branching(), 16U);
  EXPECT_EQ((*vocabulary)->levels(), 4U);
  EXPECT_EQ((*vocabulary)->direct_level(), 1U);
  EXPECT_EQ((*vocabulary)->view().training_images, 1236U);
}

TEST(ShippedVocabulary, FindsNeighboursOnARecordedStreet) {
  const char* shared = std::getenv("SEMMAP_SHARED");
  const std::string folder = std::string(shared != nullptr ? shared : SEMMAP_SOURCE_DIR "/../shared") +
                             "/data/sequences/kitti06_stereo51/image_0/";
  const auto vocabulary = Vocabulary::Load(DefaultVocabularyPath()).value();
  PlaceIndex index(vocabulary);
  OrbExtractor extractor({});
  int frame_before = 0;
  for (int frame = 0; frame < 51; frame += 2) {
    const std::string number = std::to_string(frame);
    const cv::Mat image =
        cv::imread(folder + std::string(6 - number.size(), '0') + number + ".png", cv::IMREAD_GRAYSCALE);
    if (image.empty()) GTEST_SKIP() << "no recorded images in " << folder;
    FrameFeatures features;
    extractor.Extract(image, &features);
    const BagOfWords words = vocabulary->Describe(features.descriptors).words;
    const auto matches = index.Query(words, 1);
    index.Add(KeyFrameId(frame + 1), words);
    if (frame == 0) continue;
    ASSERT_EQ(matches.size(), 1U);
    // Driving on, the frame before mostly looks most alike, sometimes one a few metres further back.
    const int frames_back = frame + 1 - static_cast<int>(matches[0].keyframe.value());
    frame_before += frames_back == 2 ? 1 : 0;
    EXPECT_LE(frames_back, 8);
    EXPECT_GT(matches[0].score, 0.05);
  }
  EXPECT_GE(frame_before, 20);
}

}  // namespace
}  // namespace semmap
