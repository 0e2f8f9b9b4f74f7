#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace semmap::town {

// CARLA's 23 semantic classes with CARLA's ids (0.9.12), the labels of the class mask.
enum class ClassId : uint8_t {
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

inline constexpr int kClassCount = 23;

struct ClassInfo {
  std::string_view name;
  std::array<uint8_t, 3> rgb;  // CARLA's palette
};

inline constexpr std::array<ClassInfo, kClassCount> kClasses = {{
    {"Unlabeled", {0, 0, 0}},         {"Building", {70, 70, 70}},     {"Fence", {100, 40, 40}},
    {"Other", {55, 90, 80}},          {"Pedestrian", {220, 20, 60}},  {"Pole", {153, 153, 153}},
    {"RoadLine", {157, 234, 50}},     {"Road", {128, 64, 128}},       {"SideWalk", {244, 35, 232}},
    {"Vegetation", {107, 142, 35}},   {"Vehicles", {0, 0, 142}},      {"Wall", {102, 102, 156}},
    {"TrafficSign", {220, 220, 0}},   {"Sky", {70, 130, 180}},        {"Ground", {81, 0, 81}},
    {"Bridge", {150, 100, 100}},      {"RailTrack", {230, 150, 140}}, {"GuardRail", {180, 165, 180}},
    {"TrafficLight", {250, 170, 30}}, {"Static", {110, 190, 160}},    {"Dynamic", {170, 120, 50}},
    {"Water", {45, 60, 150}},         {"Terrain", {145, 170, 100}},
}};

}  // namespace semmap::town
