#include <algorithm>
#include <map>
#include <vector>

#include "map_store_contract.h"
#include "storage/words_codec.h"

// What a store must do with what keyframes look like.
namespace semmap::storage {
namespace {

constexpr uint64_t kVocabulary = 0x8000000000000001;

// One word for each keypoint: a stand-in for a vocabulary.
PlaceWording Wording(uint64_t vocabulary = kVocabulary) {
  return {vocabulary, [](const FrameFeatures& features) {
            std::vector<uint32_t> words;
            for (const Descriptor& descriptor : features.descriptors)
              words.push_back(static_cast<uint32_t>(descriptor.words[0]) / 2);
            std::sort(words.begin(), words.end());
            return words;
          }};
}

class OutlineCollector : public MapOutlineReader {
 public:
  absl::Status OnMap(const MapInfo& map) override {
    info = map;
    return absl::OkStatus();
  }
  absl::Status OnKeyFrame(KeyFrameOutline keyframe) override {
    EXPECT_TRUE(keyframes.empty() || keyframes.rbegin()->first < keyframe.id);
    keyframes[keyframe.id] = std::move(keyframe);
    return absl::OkStatus();
  }

  MapInfo info;
  std::map<KeyFrameId, KeyFrameOutline> keyframes;
};

class Words : public MapStoreContract {
 protected:
  OutlineCollector Outline(MapId map, uint64_t vocabulary = kVocabulary) {
    OutlineCollector outline;
    const absl::Status status = store_->ReadOutline(map, vocabulary, &outline);
    EXPECT_TRUE(status.ok()) << status;
    return outline;
  }
  OutlineCollector Outline() { return Outline(map_); }

  std::vector<uint32_t> WordsOfStored(uint64_t id) {
    return Wording().words_of(*store_->GetKeyFrame(map_, KeyFrameId(id))->record.features);
  }
};

TEST_P(Words, AnOutlineTellsPosesAndWhatIsSeen) {
  StartSmallMap();
  const OutlineCollector outline = Outline();
  EXPECT_EQ(outline.info.version, store_->GetMap(map_)->version);
  ASSERT_EQ(outline.keyframes.size(), 3U);
  const KeyFrameOutline& first = outline.keyframes.at(KeyFrameId(1));
  EXPECT_TRUE(
      SamePose(first.map_from_camera, store_->GetKeyFrame(map_, KeyFrameId(1))->record.map_from_camera));
  const std::vector<MapPointId> seen = {MapPointId(1), MapPointId(2), MapPointId(3), MapPointId(4)};
  EXPECT_EQ(first.points, seen);
  EXPECT_TRUE(outline.keyframes.at(KeyFrameId(3)).points.empty());
  EXPECT_FALSE(first.words.has_value()) << "nobody said how";
  OutlineCollector none;
  EXPECT_TRUE(absl::IsNotFound(store_->ReadOutline(MapId(77), kVocabulary, &none)));
}

TEST_P(Words, AreStoredWithFeatures) {
  store_->StoreWordsBy(Wording());
  StartSmallMap();
  for (const auto& [id, keyframe] : Outline().keyframes) {
    ASSERT_TRUE(keyframe.words.has_value());
    EXPECT_EQ(*keyframe.words, WordsOfStored(id.value()));
  }
  EXPECT_FALSE(Outline(map_, kVocabulary + 1).keyframes.at(KeyFrameId(1)).words.has_value());
  Reopen();
  EXPECT_TRUE(Outline().keyframes.at(KeyFrameId(1)).words.has_value());
  EXPECT_EQ(Findings(*store_, map_), "");
}

TEST_P(Words, AreOfAllStoredKeypoints) {
  config_.keyframe_keypoints = 4;
  Reopen();
  store_->StoreWordsBy(Wording());
  StartMap();
  MapDelta delta;
  delta.added_keyframes.push_back(KeyFrameWith(1, 30));
  ASSERT_TRUE(Apply(delta).ok());
  const auto features = delta.added_keyframes[0].features;
  EXPECT_EQ(Outline().keyframes.at(KeyFrameId(1)).words->size(), 4U);
  // Keypoints come to see points, and are stored, later.
  MapDelta later;
  std::vector<MapPointId> sees(30);
  for (const size_t keypoint : {3, 11, 29}) {
    const uint64_t id = keypoint;
    sees[keypoint] = MapPointId(id);
    later.upserted_points.push_back(PointAt(id, {1, 1, 1}));
    later.upserted_points.back().observation_count = 1;
  }
  later.observations.push_back({KeyFrameId(1), sees, features});
  ASSERT_TRUE(Apply(later).ok());
  const std::vector<uint32_t> words = WordsOfStored(1);
  EXPECT_GT(words.size(), 4U);
  EXPECT_EQ(Outline().keyframes.at(KeyFrameId(1)).words, words);
}

TEST_P(Words, GoWhenKeypointsComeThatNobodyPutsIntoWords) {
  config_.keyframe_keypoints = 4;
  Reopen();
  store_->StoreWordsBy(Wording());
  StartMap();
  MapDelta delta;
  delta.added_keyframes.push_back(KeyFrameWith(1, 30));
  ASSERT_TRUE(Apply(delta).ok());
  Reopen();
  MapDelta later;
  std::vector<MapPointId> sees(30);
  sees[3] = MapPointId(1);
  later.upserted_points.push_back(PointAt(1, {1, 1, 1}));
  later.upserted_points.back().observation_count = 1;
  later.observations.push_back({KeyFrameId(1), sees, delta.added_keyframes[0].features});
  ASSERT_TRUE(Apply(later).ok());
  EXPECT_FALSE(Outline().keyframes.at(KeyFrameId(1)).words.has_value());
}

TEST_P(Words, MadeLaterAreKept) {
  StartSmallMap();
  const uint64_t version = store_->GetMap(map_)->version;
  const std::vector<KeyFrameWords> made = {{KeyFrameId(1), {1, 1, 5}}, {KeyFrameId(3), {}}};
  const absl::Status status = store_->StoreWords(map_, version, kVocabulary, made);
  ASSERT_TRUE(status.ok()) << status;
  const OutlineCollector outline = Outline();
  EXPECT_EQ(outline.keyframes.at(KeyFrameId(1)).words, (std::vector<uint32_t>{1, 1, 5}));
  EXPECT_EQ(outline.keyframes.at(KeyFrameId(3)).words, std::vector<uint32_t>());
  EXPECT_FALSE(outline.keyframes.at(KeyFrameId(2)).words.has_value());
  EXPECT_EQ(store_->GetMap(map_)->version, version) << "the map is what it was";
}

TEST_P(Words, OfAMapThatHasChangedAreNotKept) {
  StartSmallMap();
  const uint64_t version = store_->GetMap(map_)->version;
  const std::vector<KeyFrameWords> made = {{KeyFrameId(1), {1}}};
  EXPECT_TRUE(absl::IsAborted(store_->StoreWords(map_, version + 1, kVocabulary, made)));
  EXPECT_TRUE(absl::IsNotFound(store_->StoreWords(MapId(77), 1, kVocabulary, made)));
  EXPECT_FALSE(Outline().keyframes.at(KeyFrameId(1)).words.has_value());
}

TEST_P(Words, GoWithTheirKeyFrameAndAreCopiedWithTheirMap) {
  store_->StoreWordsBy(Wording());
  StartSmallMap();
  MapDelta delta;
  delta.removed_keyframes.push_back({KeyFrameId(3), KeyFrameId(1), SE3()});
  ASSERT_TRUE(Apply(delta).ok());
  const auto copy = store_->CopyMap(map_, "copy", 5, nullptr);
  ASSERT_TRUE(copy.ok()) << copy.status();
  const OutlineCollector outline = Outline(copy->id);
  ASSERT_EQ(outline.keyframes.size(), 2U);
  for (const auto& [id, keyframe] : outline.keyframes) EXPECT_EQ(keyframe.words, WordsOfStored(id.value()));
  EXPECT_TRUE(store_->DeleteMap(copy->id).ok());
}

TEST_P(Words, OfAFileAreNotBelieved) {
  store_->StoreWordsBy(Wording());
  StartSmallMap();
  const std::string file = dir_.File("map.semmap");
  ASSERT_TRUE(store_->ExportMap(map_, file, nullptr).ok());
  const auto imported = store_->ImportMap(file, "imported", 5, nullptr);
  ASSERT_TRUE(imported.ok()) << imported.status();
  for (const auto& [id, keyframe] : Outline(imported->id).keyframes) EXPECT_FALSE(keyframe.words.has_value());
}

TEST_P(Words, PartsAreReadAtOneVersion) {
  StartSmallMap();
  const uint64_t version = store_->GetMap(map_)->version;
  const absl::Status status = store_->ReadParts(map_, [&](MapPartReader& reader) -> absl::Status {
    EXPECT_EQ(reader.version(), version);
    MapDelta delta;
    delta.removed_points.push_back(MapPointId(2));
    delta.observations.push_back({KeyFrameId(1), std::vector<MapPointId>(8), nullptr});
    delta.observations.push_back({KeyFrameId(2), std::vector<MapPointId>(8), nullptr});
    EXPECT_TRUE(Apply(delta).ok());
    const auto keyframe = reader.ReadKeyFrame(KeyFrameId(1));
    EXPECT_TRUE(keyframe.ok() && keyframe->has_value());
    EXPECT_TRUE(SameFeatures(*(*keyframe)->record.features, *KeyFrameWith(1, 8).features));
    EXPECT_EQ((*keyframe)->observations[2], MapPointId(2));
    EXPECT_EQ((*keyframe)->bounds.max_x, UndistortedBounds(StereoRig().camera).max_x);
    EXPECT_FALSE(reader.ReadKeyFrame(KeyFrameId(9))->has_value());
    std::vector<uint64_t> ids;
    EXPECT_TRUE(reader
                    .ReadPoints(MapPointId(2), MapPointId(3),
                                [&](const MapPointRecord& point) { ids.push_back(point.id.value()); })
                    .ok());
    EXPECT_EQ(ids, (std::vector<uint64_t>{2, 3}));
    return absl::OkStatus();
  });
  EXPECT_TRUE(status.ok()) << status;
  EXPECT_TRUE(
      absl::IsNotFound(store_->ReadParts(MapId(77), [](MapPartReader&) { return absl::OkStatus(); })));
  EXPECT_TRUE(
      absl::IsAborted(store_->ReadParts(map_, [](MapPartReader&) { return absl::AbortedError("enough"); })));
}

INSTANTIATE_TEST_SUITE_P(Backends, Words, testing::ValuesIn(AllBackends()), BackendName);

TEST(WordsCodec, GivesBackWhatItTook) {
  const std::vector<std::vector<uint32_t>> samples = {
      {}, {0}, {7, 7, 7}, {0, 1, 127, 128, 70'000, 4'294'967'295}};
  for (const std::vector<uint32_t>& words : samples) {
    ByteWriter out;
    EncodeWords(words, &out);
    const auto decoded = DecodeWords(out.view());
    ASSERT_TRUE(decoded.ok()) << decoded.status();
    EXPECT_EQ(*decoded, words);
  }
}

TEST(WordsCodec, RefusesWhatWasChanged) {
  ByteWriter out;
  EncodeWords(std::vector<uint32_t>{3, 4, 400}, &out);
  const Blob sound = out.Take();
  for (size_t i = 0; i < sound.size(); ++i) {
    Blob changed = sound;
    changed[i] ^= 0x10;
    EXPECT_FALSE(DecodeWords(changed).ok()) << i;
    EXPECT_FALSE(DecodeWords(BlobView(sound).first(i)).ok()) << i;
  }
}

}  // namespace
}  // namespace semmap::storage
