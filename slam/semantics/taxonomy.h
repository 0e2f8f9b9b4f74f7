#pragma once

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace semmap {

// CARLA's 23 semantic classes with CARLA's ids (0.9.12): the one table of this project. A mask, a keypoint, a
// point and the store hold the id as uint8_t.
enum class SemanticClass : uint8_t {
  kUnlabeled = 0,
  kBuilding = 1,
  kFence = 2,
  kOther = 3,
  kPedestrian = 4,
  kPole = 5,
  kRoadLine = 6,
  kRoad = 7,
  kSideWalk = 8,
  kVegetation = 9,
  kVehicles = 10,
  kWall = 11,
  kTrafficSign = 12,
  kSky = 13,
  kGround = 14,
  kBridge = 15,
  kRailTrack = 16,
  kGuardRail = 17,
  kTrafficLight = 18,
  kStatic = 19,
  kDynamic = 20,
  kWater = 21,
  kTerrain = 22,
};

inline constexpr int kSemanticClassCount = 23;
// The id where nobody said what something is.
inline constexpr uint8_t kUnknownClass = 255;

struct SemanticClassInfo {
  std::string_view name;
  std::array<uint8_t, 3> rgb;  // CARLA's palette
};

// By id.
inline constexpr std::array<SemanticClassInfo, kSemanticClassCount> kSemanticClasses = {{
    {"Unlabeled", {0, 0, 0}},         {"Building", {70, 70, 70}},     {"Fence", {100, 40, 40}},
    {"Other", {55, 90, 80}},          {"Pedestrian", {220, 20, 60}},  {"Pole", {153, 153, 153}},
    {"RoadLine", {157, 234, 50}},     {"Road", {128, 64, 128}},       {"SideWalk", {244, 35, 232}},
    {"Vegetation", {107, 142, 35}},   {"Vehicles", {0, 0, 142}},      {"Wall", {102, 102, 156}},
    {"TrafficSign", {220, 220, 0}},   {"Sky", {70, 130, 180}},        {"Ground", {81, 0, 81}},
    {"Bridge", {150, 100, 100}},      {"RailTrack", {230, 150, 140}}, {"GuardRail", {180, 165, 180}},
    {"TrafficLight", {250, 170, 30}}, {"Static", {110, 190, 160}},    {"Dynamic", {170, 120, 50}},
    {"Water", {45, 60, 150}},         {"Terrain", {145, 170, 100}},
}};

// A set of class ids; kUnknownClass may be a member, too.
class ClassSet {
 public:
  ClassSet() = default;
  template <size_t N>
  explicit ClassSet(const std::array<SemanticClass, N>& classes) {
    for (const SemanticClass member : classes) Add(static_cast<uint8_t>(member));
  }

  void Add(uint8_t id) { members_.set(id); }
  bool Contains(uint8_t id) const { return members_[id]; }
  bool empty() const { return members_.none(); }

  friend bool operator==(const ClassSet&, const ClassSet&) = default;

 private:
  std::bitset<256> members_;
};

// What may move or says little of the place: by default its points are inactive (section 4 of the paper).
inline constexpr std::array<SemanticClass, 6> kInactiveClasses = {
    SemanticClass::kUnlabeled, SemanticClass::kOther, SemanticClass::kPedestrian,
    SemanticClass::kVehicles,  SemanticClass::kSky,   SemanticClass::kDynamic};

// Id of the class of this name, in any case; nothing for other texts.
std::optional<uint8_t> FindSemanticClass(std::string_view name);

}  // namespace semmap
