#pragma once

#include <string>

#include "nlohmann/json.hpp"
#include "tests/bench/map_scale/map_scale_measure.h"

namespace semmap::bench {

nlohmann::json MapScaleJson(const MapScaleResult& result);
// The same for people, beside what is aimed at.
std::string MapScaleTable(const MapScaleResult& result);

}  // namespace semmap::bench
