#include "server/nearest.h"

#include "server/error_reasons.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

// Half the edge of the first box, in units of the map, and how often it is doubled before all is looked at.
constexpr double kFirstRadius = 8;
constexpr int kDoublings = 10;

using Look = std::function<absl::Status(const std::optional<Eigen::AlignedBox3d>& box,
                                        const std::function<void(const Eigen::Vector3d&, uint64_t)>& offer)>;

absl::StatusOr<std::unordered_set<uint64_t>> FindNearest(const AreaFilter::Nearest& nearest,
                                                         const Look& look) {
  double radius = kFirstRadius;
  for (int i = 0; i <= kDoublings; ++i, radius *= 2) {
    const bool everywhere = i == kDoublings;
    std::optional<Eigen::AlignedBox3d> box;
    const Eigen::Vector3d half = Eigen::Vector3d::Constant(radius);
    if (!everywhere) box.emplace(nearest.point - half, nearest.point + half);
    NearestThings things(nearest.count);
    SEMMAP_RETURN_IF_ERROR(look(box, [&](const Eigen::Vector3d& position, uint64_t id) {
      const double squared = (position - nearest.point).squaredNorm();
      // In the corners of the box are things that are further than others outside of it.
      if (everywhere || squared <= radius * radius) things.Offer(squared, id);
    }));
    if (things.full() || everywhere) return things.TakeIds();
  }
  return absl::InternalError("not reached");
}

}  // namespace

void NearestThings::Offer(double squared_distance, uint64_t id) {
  furthest_first_.emplace(squared_distance, id);
  if (furthest_first_.size() > count_) furthest_first_.pop();
}

std::unordered_set<uint64_t> NearestThings::TakeIds() {
  std::unordered_set<uint64_t> ids;
  for (; !furthest_first_.empty(); furthest_first_.pop()) ids.insert(furthest_first_.top().second);
  return ids;
}

absl::Status ResolveNearest(storage::MapStore& store, storage::MapId map, PointFilter* filter) {
  if (!filter->area.nearest.has_value()) return absl::OkStatus();
  SEMMAP_ASSIGN_OR_RETURN(
      filter->area.ids, FindNearest(*filter->area.nearest, [&](const auto& box, const auto& offer) {
        storage::MapPointQuery query = filter->query;
        query.box = box;
        return FromStore(store.ForEachMapPoint(map, query, [&](const MapPointRecord& point) {
          if (filter->Contains(point)) offer(point.position_in_map, point.id.value());
          return true;
        }));
      }));
  return absl::OkStatus();
}

absl::Status ResolveNearest(storage::MapStore& store, storage::MapId map,
                            const storage::KeyFrameQuery& keyframes, AreaFilter* area) {
  if (!area->nearest.has_value()) return absl::OkStatus();
  SEMMAP_ASSIGN_OR_RETURN(
      area->ids, FindNearest(*area->nearest, [&](const auto& box, const auto& offer) {
        storage::KeyFrameQuery query = keyframes;
        query.box = box;
        query.after = {};
        return FromStore(store.ForEachKeyFrame(map, query, [&](const storage::KeyFrameEntry& entry) {
          offer(entry.record.map_from_camera.translation(), entry.record.id.value());
          return true;
        }));
      }));
  return absl::OkStatus();
}

}  // namespace semmap::server
