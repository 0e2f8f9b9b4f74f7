#include "slam/pipeline/map_part_cache.h"

#include <bit>
#include <iterator>
#include <utility>

namespace semmap {
namespace {

// What an entry takes besides its part: nodes of a list and a tree, the control block of the part.
constexpr size_t kEntryBytes = 256;

uint64_t BitOf(MapPointId id) { return uint64_t{1} << (id.value() % PointBlock::kSize); }

size_t BytesOf(const DirectIndex& nodes) {
  return sizeof(DirectIndex) + nodes.groups.capacity() * sizeof(NodeGroup) +
         nodes.keypoints.capacity() * sizeof(uint32_t);
}

}  // namespace

size_t KeyFramePart::MemoryBytes() const {
  // A grid lists each keypoint once.
  constexpr size_t kBytesOfKeypoint =
      sizeof(Keypoint) + sizeof(Descriptor) + sizeof(uint32_t) + sizeof(MapPointId) + sizeof(uint16_t);
  return sizeof(KeyFramePart) + sizeof(FrameFeatures) + sizeof(FeatureGrid) +
         features->size() * kBytesOfKeypoint;
}

void PointBlock::Add(const ViewPoint& point, bool active) {
  present_ |= BitOf(point.id);
  if (active) active_ |= BitOf(point.id);
  points_.push_back(point);
}

const ViewPoint* PointBlock::FindActive(MapPointId id) const {
  if ((active_ & BitOf(id)) == 0) return nullptr;
  return &points_[static_cast<size_t>(std::popcount(present_ & (BitOf(id) - 1)))];
}

template <typename T>
std::shared_ptr<const T> MapPartCache::Find(const Key& key, uint64_t version) {
  MutexLock lock(&mutex_);
  const auto found = by_key_.find(key);
  if (found == by_key_.end() || found->second->version != version) return nullptr;
  entries_.splice(entries_.begin(), entries_, found->second);
  return std::get<std::shared_ptr<const T>>(found->second->part);
}

std::shared_ptr<const KeyFramePart> MapPartCache::FindKeyFrame(uint64_t map, KeyFrameId id,
                                                               uint64_t version) {
  return Find<KeyFramePart>({map, Kind::kKeyFrame, id.value()}, version);
}

std::shared_ptr<const DirectIndex> MapPartCache::FindNodes(uint64_t map, KeyFrameId id, uint64_t version) {
  return Find<DirectIndex>({map, Kind::kNodes, id.value()}, version);
}

std::shared_ptr<const PointBlock> MapPartCache::FindPoints(uint64_t map, uint64_t block, uint64_t version) {
  return Find<PointBlock>({map, Kind::kPoints, block}, version);
}

void MapPartCache::Put(uint64_t map, KeyFrameId id, uint64_t version,
                       std::shared_ptr<const KeyFramePart> part) {
  const size_t bytes = part->MemoryBytes();
  Put({{map, Kind::kKeyFrame, id.value()}, version, std::move(part), bytes});
}

void MapPartCache::Put(uint64_t map, KeyFrameId id, uint64_t version,
                       std::shared_ptr<const DirectIndex> nodes) {
  const size_t bytes = BytesOf(*nodes);
  Put({{map, Kind::kNodes, id.value()}, version, std::move(nodes), bytes});
}

void MapPartCache::Put(uint64_t map, uint64_t block, uint64_t version,
                       std::shared_ptr<const PointBlock> points) {
  const size_t bytes = points->MemoryBytes();
  Put({{map, Kind::kPoints, block}, version, std::move(points), bytes});
}

void MapPartCache::Put(Entry entry) {
  entry.bytes += kEntryBytes;
  Entries gone;
  MutexLock lock(&mutex_);
  const auto [place, added] = by_key_.try_emplace(entry.key);
  if (!added) {
    bytes_ -= place->second->bytes;
    gone.splice(gone.begin(), entries_, place->second);
  }
  bytes_ += entry.bytes;
  entries_.push_front(std::move(entry));
  place->second = entries_.begin();
  MakeRoom(&gone);
}

void MapPartCache::MakeRoom(Entries* gone) {
  while (bytes_ > max_bytes_ && !entries_.empty()) {
    const auto oldest = std::prev(entries_.end());
    bytes_ -= oldest->bytes;
    by_key_.erase(oldest->key);
    gone->splice(gone->begin(), entries_, oldest);
  }
}

void MapPartCache::SetMaxBytes(size_t max_bytes) {
  Entries gone;
  MutexLock lock(&mutex_);
  max_bytes_ = max_bytes;
  MakeRoom(&gone);
}

size_t MapPartCache::memory_bytes() const {
  MutexLock lock(&mutex_);
  return bytes_;
}

}  // namespace semmap
