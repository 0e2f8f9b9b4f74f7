#include "storage/sqlite/delta_writer.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"
#include "storage/sqlite/frame_rows.h"
#include "storage/sqlite/keyframe_rows.h"
#include "storage/sqlite/map_rows.h"
#include "storage/sqlite/point_rows.h"
#include "storage/sqlite/query.h"
#include "storage/sqlite/session_rows.h"

namespace semmap::storage::sqlite {
namespace {

// No delta is applied twice, and none before the one ahead of it.
absl::Status CheckVersion(uint64_t last, uint64_t version) {
  if (version == 0) return absl::InvalidArgumentError("delta versions begin at 1");
  if (last == 0 || version == last + 1) return absl::OkStatus();
  const std::string what = absl::StrCat("delta ", version, " after delta ", last);
  if (version <= last) return absl::AlreadyExistsError(absl::StrCat(what, ": applied before"));
  return absl::FailedPreconditionError(absl::StrCat(what, ": one is missing"));
}

// The observations of a keyframe that is added in the same delta.
std::span<const MapPointId> SeenBy(const MapDelta& delta, const KeyFrameRecord& keyframe) {
  const auto found = std::find_if(delta.observations.begin(), delta.observations.end(),
                                  [&](const KeyFrameObservations& seen) { return seen.id == keyframe.id; });
  return found == delta.observations.end() ? std::span<const MapPointId>() : found->point_of_keypoint;
}

// Whether there is more in it than frames that hang on the map as it is.
bool ChangesMap(const MapDelta& delta) {
  return delta.frames.empty() || delta.reset || !delta.added_keyframes.empty() ||
         !delta.moved_keyframes.empty() || !delta.upserted_points.empty() || !delta.observations.empty() ||
         !delta.removed_keyframes.empty() || !delta.removed_points.empty();
}

// Changes that no session makes add nothing; should they try, the point would be this one's until they fail.
constexpr char kSelectAnySession[] = "SELECT min(session_id) FROM sessions WHERE map_id = ?";

// Applies one delta, member by member, and adds up what it does to map and session.
class DeltaWriter {
 public:
  DeltaWriter(Connection& connection, MapId map, SessionId session, SessionProgress progress,
              FeatureWriting writing)
      : connection_(connection),
        map_(map),
        session_(session),
        progress_(progress),
        writing_(std::move(writing)) {}

  absl::Status Write(const MapDelta& delta) {
    if (delta.reset) SEMMAP_RETURN_IF_ERROR(Reset());
    SEMMAP_RETURN_IF_ERROR(WriteKeyFrames(delta));
    SEMMAP_RETURN_IF_ERROR(WritePoints(delta));
    SEMMAP_RETURN_IF_ERROR(WriteObservationRows(delta));
    SEMMAP_RETURN_IF_ERROR(RemoveKeyFrames(delta));
    SEMMAP_RETURN_IF_ERROR(RemovePoints(delta));
    SEMMAP_RETURN_IF_ERROR(WriteFrames(delta));
    progress_.delta_version = delta.version;
    growth_.changes_map = ChangesMap(delta);
    SEMMAP_RETURN_IF_ERROR(UpdateGrowth(connection_, map_, growth_));
    return WriteProgress(connection_, map_, session_, progress_);
  }

  absl::Status Change(const MapDelta& delta) {
    SEMMAP_RETURN_IF_ERROR(WriteKeyFrames(delta));
    SEMMAP_RETURN_IF_ERROR(WritePoints(delta));
    if (growth_.points > 0) return absl::InvalidArgumentError("the changes of a map add points to it");
    SEMMAP_RETURN_IF_ERROR(WriteObservationRows(delta));
    SEMMAP_RETURN_IF_ERROR(RemoveKeyFrames(delta));
    SEMMAP_RETURN_IF_ERROR(RemovePoints(delta));
    return UpdateGrowth(connection_, map_, growth_);
  }

 private:
  absl::Status Reset() {
    SEMMAP_RETURN_IF_ERROR(EraseFramesOf(connection_, map_, session_));
    SEMMAP_ASSIGN_OR_RETURN(const int64_t keyframes, EraseKeyFramesOf(connection_, map_, session_));
    SEMMAP_ASSIGN_OR_RETURN(const int64_t points, ErasePointsOf(connection_, map_, session_));
    growth_.keyframes -= keyframes;
    growth_.points -= points;
    progress_.stored_frames = 0;
    return absl::OkStatus();
  }

  absl::Status WriteKeyFrames(const MapDelta& delta) {
    for (const KeyFrameRecord& keyframe : delta.added_keyframes) {
      SEMMAP_RETURN_IF_ERROR(
          InsertKeyFrame(connection_, map_, session_, keyframe, SeenBy(delta, keyframe), &writing_));
      ++growth_.keyframes;
      growth_.last_keyframe_id = std::max(growth_.last_keyframe_id, keyframe.id);
      NoteSequence(keyframe.sequence);
    }
    for (const KeyFramePose& moved : delta.moved_keyframes) {
      SEMMAP_RETURN_IF_ERROR(MoveKeyFrame(connection_, map_, moved));
      if (moved.rescale != 1) SEMMAP_RETURN_IF_ERROR(RescaleFrames(connection_, map_, moved));
    }
    return absl::OkStatus();
  }

  absl::Status WritePoints(const MapDelta& delta) {
    if (delta.upserted_points.empty()) return absl::OkStatus();
    SEMMAP_ASSIGN_OR_RETURN(MapPlacement placement, ReadPlacement(connection_, map_));
    if (placement.cell_size == 0) {
      placement.cell_size = ChooseCellSize(delta.upserted_points);
      SEMMAP_RETURN_IF_ERROR(SetCellSize(connection_, map_, placement.cell_size));
    }
    PointWriter writer(connection_, map_, session_, placement);
    for (const MapPointRecord& point : delta.upserted_points) {
      SEMMAP_ASSIGN_OR_RETURN(const bool added, writer.Upsert(point));
      growth_.points += added ? 1 : 0;
      growth_.last_point_id = std::max(growth_.last_point_id, point.id);
    }
    return absl::OkStatus();
  }

  absl::Status WriteObservationRows(const MapDelta& delta) {
    for (const KeyFrameObservations& observations : delta.observations) {
      SEMMAP_RETURN_IF_ERROR(WriteObservations(connection_, map_, observations, &writing_));
    }
    return absl::OkStatus();
  }

  absl::Status RemoveKeyFrames(const MapDelta& delta) {
    for (const RemovedKeyFrame& removal : delta.removed_keyframes) {
      SEMMAP_RETURN_IF_ERROR(RemoveKeyFrame(connection_, map_, removal));
      --growth_.keyframes;
    }
    return absl::OkStatus();
  }

  absl::Status RemovePoints(const MapDelta& delta) {
    for (const MapPointId point : delta.removed_points) {
      SEMMAP_ASSIGN_OR_RETURN(const bool existed, ErasePoint(connection_, map_, point));
      growth_.points -= existed ? 1 : 0;
    }
    return absl::OkStatus();
  }

  absl::Status WriteFrames(const MapDelta& delta) {
    for (const FramePose& frame : delta.frames) {
      SEMMAP_ASSIGN_OR_RETURN(const bool added, UpsertFrame(connection_, map_, session_, frame));
      progress_.stored_frames += added ? 1 : 0;
      NoteSequence(frame.sequence);
    }
    return absl::OkStatus();
  }

  void NoteSequence(uint64_t sequence) {
    progress_.last_durable_sequence = std::max(progress_.last_durable_sequence.value_or(0), sequence);
  }

  Connection& connection_;
  const MapId map_;
  const SessionId session_;
  SessionProgress progress_;
  FeatureWriting writing_;
  MapGrowth growth_;
};

}  // namespace

absl::Status WriteDelta(Connection& connection, MapId map, SessionId session, const MapDelta& delta,
                        size_t max_keypoints, const PlaceWording* wording) {
  SEMMAP_ASSIGN_OR_RETURN(const SessionProgress progress, ReadProgress(connection, map, session));
  SEMMAP_RETURN_IF_ERROR(CheckVersion(progress.delta_version, delta.version));
  return DeltaWriter(connection, map, session, progress, {max_keypoints, wording, {}}).Write(delta);
}

absl::Status WriteChanges(Connection& connection, MapId map, const MapDelta& changes) {
  SEMMAP_ASSIGN_OR_RETURN(const int64_t session, QueryInteger(connection, kSelectAnySession, map));
  return DeltaWriter(connection, map, SessionId(static_cast<uint64_t>(session)), SessionProgress(),
                     {0, nullptr, {}})
      .Change(changes);
}

}  // namespace semmap::storage::sqlite
