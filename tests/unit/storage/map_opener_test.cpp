#include "storage/map_opener.h"

#include "slam/pipeline/map_localizer.h"
#include "slam/place/vocabulary.h"
#include "storage/map_loader.h"
#include "storage_test_support.h"
#include "tests/support/ring_world.h"
#include "tests/unit/place/place_test_util.h"

namespace semmap::storage {
namespace {

using semmap::testing::DriveRing;
using semmap::testing::RandomVocabulary;
using semmap::testing::RingView;
using semmap::testing::RingWorld;

constexpr size_t kEnough = size_t{1} << 30;
constexpr double kStep = 0.13;
constexpr int kKeyFrames = 24;

class OutlineWords : public MapOutlineReader {
 public:
  absl::Status OnMap(const MapInfo&) override { return absl::OkStatus(); }
  absl::Status OnKeyFrame(KeyFrameOutline keyframe) override {
    with += keyframe.words.has_value() ? 1 : 0;
    return absl::OkStatus();
  }
  int with = 0;
};

// A drive round the ring in a store that keeps some of the keypoints.
class MapOpenerTest : public ::testing::Test {
 protected:
  MapOpenerTest() {
    StorageConfig config = ConfigFor(dir_.File("maps.db"));
    config.keyframe_keypoints = 300;
    store_ = OpenOrDie(config);
    NewMap new_map = MapNamed("ring");
    new_map.rig = camera_.rig;
    id_ = store_->CreateMap(new_map)->id;
    NewSession session = SessionOf(id_, "s1");
    session.rig = camera_.rig;
    const SessionId stored_session = store_->StartSession(session)->id;
    Map map = DriveRing(world_, camera_, kKeyFrames, kStep, {});
    MapDelta delta = map.TakeDelta();
    delta.version = 1;
    const absl::Status status = store_->Apply(id_, stored_session, delta);
    EXPECT_TRUE(status.ok()) << status;
  }

  MapOpening Opening(uint64_t vocabulary_seed = 5) {
    return {{RingWorld::ScaleInfo(), PointClassPolicy(),
             PlaceDescriber(RandomVocabulary(12, vocabulary_seed), ClassSet())},
            PlaceQueryLimits(),
            std::make_shared<MapPartCache>(kEnough)};
  }
  std::shared_ptr<const StoredMap> Open(const MapOpening& opening) {
    auto map = OpenMap(*store_, id_, opening, kEnough);
    EXPECT_TRUE(map.ok()) << map.status();
    return map.value_or(nullptr);
  }
  int StoredWords(const MapOpening& opening) {
    OutlineWords outline;
    EXPECT_TRUE(store_->ReadOutline(id_, opening.reading.describer->fingerprint(), &outline).ok());
    return outline.with;
  }

  TempDir dir_;
  std::unique_ptr<MapStore> store_;
  const RingWorld world_{1};
  const MappingCamera camera_ = RingWorld::Camera(SensorType::kStereo);
  MapId id_;
};

TEST_F(MapOpenerTest, AnswersAreThoseOfTheWholeMapToTheLastBit) {
  const auto opened = Open(Opening());
  ASSERT_NE(opened, nullptr);
  auto restored = LoadMap(*store_, id_, RingWorld::ScaleInfo(), kEnough);
  ASSERT_TRUE(restored.ok()) << restored.status();
  const auto whole = MakeMapSnapshot(std::move(restored->map), 0, restored->info.version, true,
                                     RandomVocabulary(12, 5), PlaceQueryLimits());
  EXPECT_EQ(opened->version(), whole->version());
  EXPECT_EQ(opened->keyframe_count(), whole->keyframe_count());
  EXPECT_EQ(opened->point_count(), whole->point_count());
  const MapLocalizer localizer(RelocalizationConfig(), 1);
  int found = 0;
  for (int i = 0; i < 12; ++i) {
    const RingView view = world_.View(camera_, RingWorld::WorldFromCamera((1.3 + 1.7 * i) * kStep),
                                      static_cast<uint32_t>(100 + i));
    const FeatureGrid grid(camera_.bounds, view.features.keypoints);
    const SearchImage image{view.features, grid};
    const auto here = localizer.Locate(*opened, camera_, image, PlacePrior());
    const auto there = localizer.Locate(*whole, camera_, image, PlacePrior());
    ASSERT_TRUE(here.ok() && there.ok()) << here.status() << there.status();
    ASSERT_EQ(here->found.has_value(), there->found.has_value()) << i;
    EXPECT_EQ(here->failure, there->failure);
    if (!here->found) continue;
    ++found;
    EXPECT_TRUE(SamePose(here->found->fix.camera_from_map, there->found->fix.camera_from_map)) << i;
    EXPECT_EQ(here->found->fix.matches, there->found->fix.matches);
  }
  EXPECT_GE(found, 10);
}

TEST_F(MapOpenerTest, WordsAreMadeOnceAndKept) {
  const MapOpening opening = Opening();
  EXPECT_EQ(StoredWords(opening), 0);
  const auto first = Open(opening);
  EXPECT_EQ(StoredWords(opening), kKeyFrames);
  const auto second = Open(opening);
  for (uint64_t id = 1; id <= kKeyFrames; ++id) {
    const KeyFrameId keyframe(id);
    ASSERT_NE(first->places()->Find(keyframe), nullptr);
    EXPECT_EQ(*first->places()->Find(keyframe), *second->places()->Find(keyframe));
    const auto stored = store_->GetKeyFrame(id_, keyframe);
    EXPECT_EQ(*second->places()->Find(keyframe),
              opening.reading.describer->Describe(*stored->record.features).words);
  }
  EXPECT_EQ(second->version(), store_->GetMap(id_)->version) << "to keep words is no change of the map";
}

TEST_F(MapOpenerTest, WordsOfAnotherVocabularyAreMadeAnew) {
  Open(Opening(5));
  EXPECT_EQ(StoredWords(Opening(6)), 0);
  const auto map = Open(Opening(6));
  EXPECT_EQ(map->places()->size(), static_cast<size_t>(kKeyFrames));
  EXPECT_EQ(StoredWords(Opening(6)), kKeyFrames);
}

TEST_F(MapOpenerTest, OfTheMapLittleIsInMemory) {
  const auto map = Open(Opening());
  const auto whole = LoadMap(*store_, id_, RingWorld::ScaleInfo(), kEnough);
  EXPECT_LT(map->memory_bytes(), whole->memory_bytes / 2);
  EXPECT_TRUE(absl::IsResourceExhausted(OpenMap(*store_, id_, Opening(), 1000).status()));
  EXPECT_TRUE(absl::IsNotFound(OpenMap(*store_, MapId(99), Opening(), kEnough).status()));
}

TEST_F(MapOpenerTest, WithoutAVocabularyThereAreNoPlaces) {
  MapOpening opening = Opening();
  opening.reading.describer.reset();
  const auto map = Open(opening);
  ASSERT_NE(map, nullptr);
  EXPECT_EQ(map->places(), nullptr);
  EXPECT_EQ(map->keyframe_count(), static_cast<size_t>(kKeyFrames));
}

}  // namespace
}  // namespace semmap::storage
