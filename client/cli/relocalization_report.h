#pragma once

#include <string>

#include "nlohmann/json.hpp"
#include "semmap/v1/localization_service.pb.h"

namespace semmap::client {

// "FOUND", "NO_CANDIDATES", ...
std::string ResultName(v1::RelocalizeResult result);

// One answer: image, result, and, where there is one, the pose as position and quaternion (x, y, z, w), with
// all digits.
nlohmann::json RelocalizationJson(const std::string& image, const v1::RelocalizeResponse& response);

// A row for each of an array of such answers.
std::string RelocalizationTable(const nlohmann::json& answers);

}  // namespace semmap::client
