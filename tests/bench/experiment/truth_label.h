#pragma once

#include <cstdint>

#include <opencv2/core/mat.hpp>

#include "client/town/drive.h"
#include "slam/semantics/taxonomy.h"

namespace semmap::bench {

// What a pixel of the town truly shows, in one byte: the class in the low five bits, and two flags.
struct TruthLabel {
  uint8_t semantic_class = 0;
  // A vehicle that takes part in traffic, or a pedestrian: it moves, has moved or will. Parked vehicles do
  // not.
  bool traffic = false;
  // Traffic that moves at this instant.
  bool moving = false;

  friend bool operator==(const TruthLabel&, const TruthLabel&) = default;
};

constexpr uint8_t kTruthClassBits = 0x1F;
constexpr uint8_t kTruthTraffic = 0x20;
constexpr uint8_t kTruthMoving = 0x40;

constexpr uint8_t Encode(const TruthLabel& label) {
  return static_cast<uint8_t>((label.semantic_class & kTruthClassBits) | (label.traffic ? kTruthTraffic : 0) |
                              (label.moving ? kTruthMoving : 0));
}
constexpr TruthLabel DecodeLabel(uint8_t code) {
  return {static_cast<uint8_t>(code & kTruthClassBits), (code & kTruthTraffic) != 0,
          (code & kTruthMoving) != 0};
}

// Encoded labels of the left image of the frame that the drive has just drawn, CV_8UC1: a vehicle's pixel
// belongs to traffic when it lies within the outline of one of the simulation's vehicles.
cv::Mat LabelTruth(const town::TownDrive& drive, const town::DriveFrame& frame);

}  // namespace semmap::bench
