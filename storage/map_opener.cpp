#include "storage/map_opener.h"

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include <spdlog/spdlog.h>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "slam/map/map_outline.h"

namespace semmap::storage {
namespace {

// Keyframes whose words are made in one go: a read transaction must not last long.
constexpr size_t kKeyFramesPerStep = 64;

class PartSource : public MapPartSource {
 public:
  PartSource(MapStore& store, MapId map) : store_(store), map_(map) {}
  absl::Status Read(absl::FunctionRef<absl::Status(MapPartReader&)> read) override {
    return store_.ReadParts(map_, read);
  }

 private:
  MapStore& store_;
  const MapId map_;
};

// Takes the outline up as it is read.
class Opener : public MapOutlineReader {
 public:
  Opener(const std::optional<PlaceDescriber>& describer, size_t max_bytes)
      : describer_(describer), max_bytes_(max_bytes) {}

  absl::Status OnMap(const MapInfo& map) override {
    info_ = map;
    outline_.emplace(map.keyframe_count, map.last_point_id);
    bags_.reserve(describer_ ? map.keyframe_count : 0);
    return CheckSize();
  }

  absl::Status OnKeyFrame(KeyFrameOutline keyframe) override {
    SEMMAP_RETURN_IF_ERROR(outline_->Add(keyframe.id, keyframe.map_from_camera, keyframe.points));
    if (describer_ && keyframe.words) {
      AddBag(keyframe.id, *keyframe.words);
    } else if (describer_) {
      missing_.push_back(keyframe.id);
    }
    return CheckSize();
  }

  // Makes what words are missing, and has the store keep them. What has gone since has no bag.
  absl::Status MakeMissingWords(MapStore& store) {
    for (size_t begin = 0; begin < missing_.size(); begin += kKeyFramesPerStep) {
      const size_t count = std::min(kKeyFramesPerStep, missing_.size() - begin);
      SEMMAP_RETURN_IF_ERROR(MakeWords(store, std::span(missing_).subspan(begin, count)));
      SEMMAP_RETURN_IF_ERROR(CheckSize());
    }
    return absl::OkStatus();
  }

  StoredMap::Core Finish(const PlaceQueryLimits& limits) && {
    StoredMap::Core core;
    core.version = info_.version;
    core.scale_known = info_.scale_known;
    core.outline = std::move(*outline_).Finish();
    if (!describer_) return core;
    core.places.emplace(describer_->vocabulary(), limits);
    // In one order always: equal scores are told apart by it.
    std::sort(bags_.begin(), bags_.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    core.places->AddAll(std::move(bags_));
    return core;
  }

 private:
  void AddBag(KeyFrameId id, const std::vector<uint32_t>& words) {
    bags_.emplace_back(id, describer_->BagOf(words));
    // In the index each word has a posting besides.
    bag_bytes_ += bags_.back().second.size() * (sizeof(WordWeight) + sizeof(Posting));
  }

  absl::Status MakeWords(MapStore& store, std::span<const KeyFrameId> ids) {
    uint64_t version = 0;
    std::vector<KeyFrameWords> made;
    SEMMAP_RETURN_IF_ERROR(store.ReadParts(info_.id, [&](MapPartReader& reader) -> absl::Status {
      version = reader.version();
      for (const KeyFrameId id : ids) {
        SEMMAP_ASSIGN_OR_RETURN(const auto keyframe, reader.ReadKeyFrame(id));
        if (keyframe) made.push_back({id, describer_->WordsOf(*keyframe->record.features)});
      }
      return absl::OkStatus();
    }));
    for (const KeyFrameWords& keyframe : made) AddBag(keyframe.id, keyframe.words);
    const absl::Status kept = store.StoreWords(info_.id, version, describer_->fingerprint(), made);
    // Then they are made once more the next time.
    if (!kept.ok()) spdlog::warn("storage: words of map {} are not kept: {}", info_.name, kept.ToString());
    return absl::OkStatus();
  }

  absl::Status CheckSize() const {
    if (outline_->MemoryBytes() + bag_bytes_ <= max_bytes_) return absl::OkStatus();
    return absl::ResourceExhaustedError(
        absl::StrCat("the map's outline takes more than ", max_bytes_ >> 20, " MB of memory"));
  }

  const std::optional<PlaceDescriber>& describer_;
  const size_t max_bytes_;
  MapInfo info_;
  std::optional<MapOutlineBuilder> outline_;
  std::vector<std::pair<KeyFrameId, BagOfWords>> bags_;
  size_t bag_bytes_ = 0;
  std::vector<KeyFrameId> missing_;
};

}  // namespace

absl::StatusOr<std::shared_ptr<const StoredMap>> OpenMap(MapStore& store, MapId map,
                                                         const MapOpening& opening, size_t max_bytes) {
  const std::optional<PlaceDescriber>& describer = opening.reading.describer;
  Opener opener(describer, max_bytes);
  SEMMAP_RETURN_IF_ERROR(store.ReadOutline(map, describer ? describer->fingerprint() : 0, &opener));
  SEMMAP_RETURN_IF_ERROR(opener.MakeMissingWords(store));
  return std::make_shared<const StoredMap>(opening.reading, std::move(opener).Finish(opening.query),
                                           std::make_shared<PartSource>(store, map), opening.cache,
                                           map.value());
}

PlaceWording WordingOf(const PlaceDescriber& describer) {
  return {describer.fingerprint(),
          [describer](const FrameFeatures& features) { return describer.WordsOf(features); }};
}

}  // namespace semmap::storage
