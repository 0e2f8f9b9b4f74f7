#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "slam/map/local_map_view.h"
#include "slam/map/map.h"
#include "slam/pipeline/place_memory.h"
#include "slam/pipeline/slam_config.h"
#include "slam/pipeline/view_localizer.h"

namespace semmap {

// What came of looking for an image in a map.
struct Relocalization {
  // Where it was found: the surroundings of the keyframe it resembles (view->reference()), and its pose
  // there.
  std::shared_ptr<const LocalMapView> view;
  std::optional<ViewFix> fix;
  // Otherwise what stopped the candidate that came furthest.
  LocalizationFailure failure = LocalizationFailure::kNoCandidates;
  int candidates = 0;
  int matches = 0;
  int inliers = 0;
};

// Finds a camera anywhere in a map: keyframes that look alike, then LocateInView around each (Mur-Artal et
// al. 2015, section V-D). Holds no state of its own; deterministic.
class Relocalizer {
 public:
  Relocalizer(const RelocalizationConfig& config, uint32_t seed) : config_(config), seed_(seed) {}

  // `version` becomes the view's.
  Relocalization Relocalize(const Map& map, const PlaceMemory& places, const MappingCamera& camera,
                            const SearchImage& image, uint64_t version) const;

 private:
  RelocalizationConfig config_;
  uint32_t seed_;
};

}  // namespace semmap
