#pragma once

#include <cstddef>
#include <functional>
#include <queue>
#include <unordered_set>
#include <utility>

#include "absl/status/status.h"
#include "server/area_filter.h"
#include "server/point_filter.h"
#include "storage/map_store.h"

namespace semmap::server {

// Turns "the nearest n of what passes the filter" into the ids of these; filters that ask for nothing of the
// kind stay as they are. Looks at ever larger boxes around the point until there are enough, then at
// everything: the box index makes it fast where things are near. The store's errors.
absl::Status ResolveNearest(storage::MapStore& store, storage::MapId map, PointFilter* filter);
absl::Status ResolveNearest(storage::MapStore& store, storage::MapId map, const storage::KeyFrameQuery& query,
                            AreaFilter* area);

// The n nearest of many things, one after the other. Of equally near ones those of smaller ids.
class NearestThings {
 public:
  explicit NearestThings(size_t count) : count_(count) {}

  void Offer(double squared_distance, uint64_t id);
  bool full() const { return furthest_first_.size() == count_; }
  std::unordered_set<uint64_t> TakeIds();

 private:
  size_t count_;
  std::priority_queue<std::pair<double, uint64_t>> furthest_first_;
};

}  // namespace semmap::server
