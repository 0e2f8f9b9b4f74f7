#pragma once

#include <cstddef>
#include <optional>

#include "absl/status/statusor.h"
#include "storage/map_store.h"
#include "storage/sqlite/connection.h"
#include "storage/sqlite/joined_copy.h"
#include "storage/sqlite/map_copy.h"

namespace semmap::storage::sqlite {

// MapStore::RewriteMap in bounded steps, each a transaction of the caller's: a copy of the map that has no
// name, to which the other map's contents and the changes are added, and which takes the map's place at the
// end. What a crash leaves is a hidden map on one side or the other, purged like a deleted one.
class RewriteSteps {
 public:
  // `rewrite` outlives this. NOT_FOUND, ABORTED.
  static absl::StatusOr<RewriteSteps> Begin(Connection& connection, const MapRewrite& rewrite);

  MapId result() const { return copy_.copy(); }
  // True when nothing is left but Finish.
  absl::StatusOr<bool> Step(Connection& connection);
  double Progress() const;
  // The result takes the place of the map, which is hidden now, and so is the joined one if it is to be
  // deleted. ABORTED when either was changed or deleted meanwhile.
  absl::Status Finish(Connection& connection);

 private:
  enum class Stage { kCopy, kJoin, kCount, kChange, kDone };

  RewriteSteps(const MapRewrite* rewrite, MapCopy copy) : rewrite_(rewrite), copy_(std::move(copy)) {}

  absl::StatusOr<bool> StepOf(Stage stage, Connection& connection);
  absl::Status Count(Connection& connection) const;
  absl::StatusOr<bool> ChangeNext(Connection& connection);
  size_t ChangeCount() const;

  const MapRewrite* rewrite_;
  MapCopy copy_;
  std::optional<JoinedCopy> join_;
  Stage stage_ = Stage::kCopy;
  size_t changed_ = 0;  // of the changes, in their order
};

}  // namespace semmap::storage::sqlite
