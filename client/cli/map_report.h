#pragma once

#include <string>

#include "nlohmann/json.hpp"
#include "semmap/v1/map.pb.h"
#include "semmap/v1/map_service.pb.h"

namespace semmap::client {

const char* MapStateName(v1::MapState state);
nlohmann::json MapJson(const v1::Map& map);
nlohmann::json MapSummaryJson(const v1::MapSummary& summary);
std::string MapSummaryTable(const v1::MapSummary& summary);

nlohmann::json MapCheckJson(const v1::CheckMapResponse& response);
std::string MapCheckTable(const v1::CheckMapResponse& response);

}  // namespace semmap::client
