#include "client/cli/class_names.h"

#include <array>

#include "absl/strings/match.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace semmap::client {
namespace {

constexpr uint32_t kUnknownClass = 255;
constexpr std::array<const char*, 23> kNames = {
    "Unlabeled", "Building",   "Fence",        "Other",  "Pedestrian",  "Pole",  "RoadLine", "Road",
    "SideWalk",  "Vegetation", "Vehicles",     "Wall",   "TrafficSign", "Sky",   "Ground",   "Bridge",
    "RailTrack", "GuardRail",  "TrafficLight", "Static", "Dynamic",     "Water", "Terrain"};

}  // namespace

std::string ClassName(uint32_t id) {
  if (id == kUnknownClass) return "-";
  return id < kNames.size() ? std::string(kNames[id]) : absl::StrCat(id);
}

std::optional<uint32_t> ParseClass(absl::string_view text) {
  for (uint32_t id = 0; id < kNames.size(); ++id) {
    if (absl::EqualsIgnoreCase(text, kNames[id])) return id;
  }
  uint32_t id = 0;
  if (!absl::SimpleAtoi(text, &id) || id > kUnknownClass) return std::nullopt;
  return id;
}

}  // namespace semmap::client
