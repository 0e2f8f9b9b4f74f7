#pragma once

#include <cstdint>
#include <string_view>

#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"

namespace semmap::storage::sqlite {

// Copies a map in bounded steps, each a transaction of the caller's, so that other writers get their turn.
// The copy has no name until it is whole: nobody sees it before, and what a crash leaves of it is purged like
// a deleted map.
class MapCopy {
 public:
  // Where the source is: in the copy's database, or in one that the connection has attached as "source".
  enum class From { kSameDatabase, kAttached };

  // NOT_FOUND.
  static absl::StatusOr<MapCopy> Begin(Connection& connection, From from, MapId source,
                                       TimestampNs created_at);

  MapId copy() const { return copy_; }
  // True when all is copied.
  absl::StatusOr<bool> Step(Connection& connection);
  // Share of the work that is done, [0, 1].
  double Progress() const;
  // Shows the copy. ALREADY_EXISTS; ABORTED when the source was changed or deleted meanwhile.
  absl::Status Finish(Connection& connection, std::string_view name);

 private:
  enum class Stage { kSessions, kKeyFrames, kKeyFrameCells, kPoints, kFrames, kDone };

  MapCopy(From from, MapId source, MapId copy, uint64_t version, uint64_t rows);

  absl::StatusOr<int64_t> CopyKeyFrames(Connection& connection) const;
  absl::StatusOr<int64_t> CopyPoints(Connection& connection) const;
  absl::StatusOr<int64_t> CopyOf(Stage stage, Connection& connection) const;

  From from_;
  MapId source_;
  MapId copy_;
  uint64_t version_;
  uint64_t rows_;      // keyframes and points to copy
  uint64_t done_ = 0;  // of those
  Stage stage_ = Stage::kSessions;
};

}  // namespace semmap::storage::sqlite
