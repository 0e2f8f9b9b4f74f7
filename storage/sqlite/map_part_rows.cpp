#include "storage/sqlite/map_part_rows.h"

#include <unordered_map>
#include <utility>

#include "slam/common/status_macros.h"
#include "storage/sqlite/keyframe_rows.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/session_rows.h"

namespace semmap::storage::sqlite {
namespace {

class PartReader : public MapPartReader {
 public:
  PartReader(Connection& connection, MapId map, uint64_t version)
      : connection_(connection), map_(map), version_(version) {}

  uint64_t version() const override { return version_; }

  absl::StatusOr<std::optional<StoredKeyFrame>> ReadKeyFrame(KeyFrameId id) override {
    std::optional<StoredKeyFrame> stored;
    absl::StatusOr<KeyFrameEntry> entry = sqlite::ReadKeyFrame(connection_, map_, id);
    if (absl::IsNotFound(entry.status())) return stored;
    SEMMAP_RETURN_IF_ERROR(entry.status());
    SEMMAP_ASSIGN_OR_RETURN(KeyFrameObservations observations, ReadObservations(connection_, map_, id));
    SEMMAP_ASSIGN_OR_RETURN(const ImageBounds bounds, BoundsOf(entry->session));
    stored = StoredKeyFrame{std::move(entry->record), bounds, std::move(observations.point_of_keypoint)};
    return stored;
  }

  absl::Status ReadPoints(MapPointId first, MapPointId last,
                          absl::FunctionRef<void(const MapPointRecord&)> visit) override {
    return VisitPointRange(connection_, map_, first, last, visit);
  }

 private:
  absl::StatusOr<ImageBounds> BoundsOf(SessionId session) {
    const auto known = bounds_.find(session);
    if (known != bounds_.end()) return known->second;
    SEMMAP_ASSIGN_OR_RETURN(const SessionInfo info, ReadSession(connection_, map_, session));
    return bounds_.emplace(session, UndistortedBounds(info.rig.camera)).first->second;
  }

  Connection& connection_;
  const MapId map_;
  const uint64_t version_;
  std::unordered_map<SessionId, ImageBounds, IdHash> bounds_;
};

}  // namespace

absl::Status ReadMapParts(Connection& connection, MapId map,
                          absl::FunctionRef<absl::Status(MapPartReader&)> read) {
  SEMMAP_ASSIGN_OR_RETURN(const MapInfo info, ReadMap(connection, map));
  PartReader reader(connection, map, info.version);
  return read(reader);
}

}  // namespace semmap::storage::sqlite
