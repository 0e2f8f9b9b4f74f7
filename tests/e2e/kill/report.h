#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "rounds.h"

namespace semmap::kill_test {

nlohmann::json ReportJson(const Rounds& rounds, uint64_t seed);
// The same for people.
std::string ReportTable(const nlohmann::json& report);

}  // namespace semmap::kill_test
