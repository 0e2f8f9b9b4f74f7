#pragma once

#include <string>

#include "nlohmann/json.hpp"

#include "client/client.h"
#include "semmap/v1/map_service.pb.h"

namespace semmap::client {

// What merge, optimize and prune say of what they did, for programs and for people. After a dry run nothing
// has changed.
nlohmann::json MergeJson(const v1::MergeMapsResponse& response, bool dry_run);
std::string MergeTable(const v1::MergeMapsResponse& response, bool dry_run);
nlohmann::json OptimizeJson(const Client::Optimized& optimized);
std::string OptimizeTable(const Client::Optimized& optimized);
nlohmann::json PruneJson(const Client::Pruned& pruned, bool dry_run);
std::string PruneTable(const Client::Pruned& pruned, bool dry_run);

}  // namespace semmap::client
