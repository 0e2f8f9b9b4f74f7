#include "slam/map/map_outline.h"

#include <algorithm>
#include <bit>

#include "absl/strings/str_cat.h"

namespace semmap {
namespace {

constexpr uint64_t kBlock = 64;

uint64_t BitOf(MapPointId id) { return uint64_t{1} << (id.value() % kBlock); }

}  // namespace

std::optional<uint32_t> MapOutline::SlotOf(KeyFrameId id) const {
  const auto found =
      std::lower_bound(places_.begin(), places_.end(), id,
                       [](const Place& place, KeyFrameId wanted) { return place.id < wanted; });
  if (found == places_.end() || found->id != id) return std::nullopt;
  return static_cast<uint32_t>(found - places_.begin());
}

std::optional<uint32_t> MapOutline::IndexOf(MapPointId id) const {
  const uint64_t block = id.value() / kBlock;
  if (block >= blocks_.size() || (blocks_[block].used & BitOf(id)) == 0) return std::nullopt;
  return blocks_[block].first_index +
         static_cast<uint32_t>(std::popcount(blocks_[block].used & (BitOf(id) - 1)));
}

std::span<const uint32_t> MapOutline::PointsOf(uint32_t slot) const {
  return {points_.begin() + points_begin_[slot], points_.begin() + points_begin_[slot + 1]};
}

std::span<const uint32_t> MapOutline::ObserversOf(uint32_t index) const {
  return {observers_.begin() + observers_begin_[index], observers_.begin() + observers_begin_[index + 1]};
}

size_t MapOutline::MemoryBytes() const {
  return places_.capacity() * sizeof(Place) + blocks_.capacity() * sizeof(IdBlock) +
         point_ids_.capacity() * sizeof(MapPointId) +
         (points_begin_.capacity() + points_.capacity() + observers_begin_.capacity() +
          observers_.capacity()) *
             sizeof(uint32_t);
}

MapOutlineBuilder::MapOutlineBuilder(size_t keyframes, MapPointId last_point) : last_point_(last_point) {
  outline_.places_.reserve(keyframes);
  outline_.points_begin_.reserve(keyframes + 1);
}

absl::Status MapOutlineBuilder::Add(KeyFrameId id, const SE3& map_from_camera,
                                    std::span<const MapPointId> points) {
  if (!outline_.places_.empty() && outline_.places_.back().id >= id)
    return absl::DataLossError(absl::StrCat("keyframe ", id.value(), " is out of order"));
  for (const MapPointId point : points) {
    if (!point.IsValid() || point > last_point_) {
      return absl::DataLossError(
          absl::StrCat("keyframe ", id.value(), " sees point ", point.value(), ", which the map never had"));
    }
  }
  seen_.insert(seen_.end(), points.begin(), points.end());
  outline_.places_.push_back({id, map_from_camera.Inverse()});
  outline_.points_begin_.push_back(static_cast<uint32_t>(seen_.size()));
  return absl::OkStatus();
}

size_t MapOutlineBuilder::MemoryBytes() const {
  // A point is seen by two keyframes at least.
  constexpr size_t kBytesOfPoint = sizeof(MapPointId) + sizeof(uint32_t);
  return outline_.places_.size() * (sizeof(MapOutline::Place) + sizeof(uint32_t)) +
         (last_point_.value() / kBlock + 1) * sizeof(MapOutline::IdBlock) +
         seen_.size() * (2 * sizeof(uint32_t) + kBytesOfPoint / 2);
}

void MapOutlineBuilder::NumberPoints() {
  std::vector<MapOutline::IdBlock>& blocks = outline_.blocks_;
  blocks.resize(seen_.empty() ? 0 : last_point_.value() / kBlock + 1);
  for (const MapPointId id : seen_) blocks[id.value() / kBlock].used |= BitOf(id);
  uint32_t count = 0;
  for (MapOutline::IdBlock& block : blocks) {
    block.first_index = count;
    count += static_cast<uint32_t>(std::popcount(block.used));
  }
  outline_.point_ids_.reserve(count);
  for (uint64_t block = 0; block < blocks.size(); ++block) {
    for (uint64_t rest = blocks[block].used; rest != 0; rest &= rest - 1) {
      outline_.point_ids_.emplace_back(block * kBlock + static_cast<uint64_t>(std::countr_zero(rest)));
    }
  }
  outline_.points_.reserve(seen_.size());
  for (const MapPointId id : seen_) outline_.points_.push_back(*outline_.IndexOf(id));
  seen_ = {};
}

void MapOutlineBuilder::ListObservers() {
  std::vector<uint32_t>& begin = outline_.observers_begin_;
  begin.assign(outline_.point_ids_.size() + 1, 0);
  for (const uint32_t point : outline_.points_) ++begin[point + 1];
  for (size_t i = 1; i < begin.size(); ++i) begin[i] += begin[i - 1];
  outline_.observers_.resize(outline_.points_.size());
  std::vector<uint32_t> next(begin.begin(), begin.end() - 1);
  for (uint32_t slot = 0; slot < outline_.places_.size(); ++slot) {
    for (const uint32_t point : outline_.PointsOf(slot)) outline_.observers_[next[point]++] = slot;
  }
}

MapOutline MapOutlineBuilder::Finish() && {
  NumberPoints();
  ListObservers();
  return std::move(outline_);
}

}  // namespace semmap
