#pragma once

#include <compare>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <variant>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "slam/common/ids.h"
#include "slam/common/mutex.h"
#include "slam/features/feature_grid.h"
#include "slam/features/frame_features.h"
#include "slam/geometry/se3.h"
#include "slam/map/local_map_view.h"
#include "slam/place/place_description.h"

namespace semmap {

// A keyframe that was read from a stored map.
struct KeyFramePart {
  SE3 camera_from_map;
  std::shared_ptr<const FrameFeatures> features;
  std::shared_ptr<const FeatureGrid> grid;
  std::vector<MapPointId> points;  // by keypoint; none where it sees none

  size_t MemoryBytes() const;
};

// The points with ids in [64 n, 64 n + 64), read together: what one keyframe made has ids in a row.
class PointBlock {
 public:
  static constexpr uint64_t kSize = 64;
  static uint64_t NumberOf(MapPointId id) { return id.value() / kSize; }

  // In order of ids.
  void Add(const ViewPoint& point, bool active);
  // nullptr when it is not there or inactive.
  const ViewPoint* FindActive(MapPointId id) const;
  size_t MemoryBytes() const { return sizeof(*this) + points_.capacity() * sizeof(ViewPoint); }

 private:
  uint64_t present_ = 0;  // a bit for each id
  uint64_t active_ = 0;
  std::vector<ViewPoint> points_;
};

// Parts of stored maps in memory, up to a number of bytes: what was not asked for longest goes first. What
// others hold of it stays with them. Each part is known by the version of its map that it was read at, and
// found under no other. Thread-safe.
class MapPartCache {
 public:
  enum class Kind : uint8_t { kKeyFrame, kNodes, kPoints };
  struct Key {
    uint64_t map = 0;
    Kind kind = Kind::kKeyFrame;
    uint64_t number = 0;

    friend auto operator<=>(const Key&, const Key&) = default;
  };

  explicit MapPartCache(size_t max_bytes) : max_bytes_(max_bytes) {}

  // nullptr when it is not there at this version.
  std::shared_ptr<const KeyFramePart> FindKeyFrame(uint64_t map, KeyFrameId id, uint64_t version);
  std::shared_ptr<const DirectIndex> FindNodes(uint64_t map, KeyFrameId id, uint64_t version);
  std::shared_ptr<const PointBlock> FindPoints(uint64_t map, uint64_t block, uint64_t version);

  void Put(uint64_t map, KeyFrameId id, uint64_t version, std::shared_ptr<const KeyFramePart> part);
  void Put(uint64_t map, KeyFrameId id, uint64_t version, std::shared_ptr<const DirectIndex> nodes);
  void Put(uint64_t map, uint64_t block, uint64_t version, std::shared_ptr<const PointBlock> points);

  // Makes room at once when there is less of it.
  void SetMaxBytes(size_t max_bytes);
  size_t memory_bytes() const;

 private:
  using Part = std::variant<std::shared_ptr<const KeyFramePart>, std::shared_ptr<const DirectIndex>,
                            std::shared_ptr<const PointBlock>>;
  struct Entry {
    Key key;
    uint64_t version = 0;
    Part part;
    size_t bytes = 0;
  };
  using Entries = std::list<Entry>;

  template <typename T>
  std::shared_ptr<const T> Find(const Key& key, uint64_t version);
  void Put(Entry entry);
  // Moves what has to go into `gone`, which must not die under the lock.
  void MakeRoom(Entries* gone) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  mutable Mutex mutex_;  // guards all below
  size_t max_bytes_ ABSL_GUARDED_BY(mutex_);
  size_t bytes_ ABSL_GUARDED_BY(mutex_) = 0;
  Entries entries_ ABSL_GUARDED_BY(mutex_);  // asked for last comes first
  std::map<Key, Entries::iterator> by_key_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap
