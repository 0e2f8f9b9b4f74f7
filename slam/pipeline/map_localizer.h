#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "absl/status/statusor.h"
#include "slam/map/map.h"
#include "slam/pipeline/map_snapshot.h"
#include "slam/pipeline/mapping_camera.h"
#include "slam/pipeline/place_memory.h"
#include "slam/pipeline/slam_config.h"
#include "slam/pipeline/view_localizer.h"

namespace semmap {

// What is known of a camera before looking. Nothing, by default.
struct PlacePrior {
  struct Position {
    Eigen::Vector3d in_map = Eigen::Vector3d::Zero();
    double radius = 0;  // units of the map; the camera is no further away
    // Unit length: nothing is known of the height along it, distances are measured across it. Zero: all is
    // known.
    Eigen::Vector3d up_in_map = Eigen::Vector3d::Zero();

    double DistanceTo(const Eigen::Vector3d& point_in_map) const;
  };
  struct Heading {
    Eigen::Vector3d in_map = Eigen::Vector3d::UnitZ();  // unit length
    double tolerance = 0;                               // radians, (0, pi]
  };
  std::optional<Position> position;
  std::optional<Heading> heading;

  bool Admits(const SE3& map_from_camera) const;
};

// Where an image was found in a map.
struct MapFix {
  // The points among which it was found, around view->reference(), a keyframe that sees much of it and the
  // only one in the view.
  std::shared_ptr<const LocalMapView> view;
  ViewFix fix;
};

// What came of looking for an image in a whole map.
struct MapLocalization {
  std::optional<MapFix> found;
  // Otherwise what stopped the candidate that came furthest. kDegeneratePose also when two places explain the
  // image about equally well.
  LocalizationFailure failure = LocalizationFailure::kNoCandidates;
  int candidates = 0;
  // Of the best place, whether it was accepted or not.
  int matches = 0;
  Agreement agreement;
  // Inliers of the next best place that is another one.
  int rival_inliers = 0;
};

// Finds a camera anywhere in a map that it may know nothing of: other than Relocalizer, which helps a tracker
// that was lost a moment ago, it looks at all candidates before it believes one, since an answer that is
// wrong is worse than none. Each place that looks alike (PlaceIndex) is tried by LocateInView; the best pose
// is refined among the points of the keyframe that sees most of it; it is accepted by inliers, by their share
// of what should be in sight there, by how well they fix the camera, and only if no other place has
// comparable support. Holds no state; deterministic; thread-safe as long as nobody changes map and places.
// What surrounds a place is looked at only once the keyframe's own points give a pose: hardly any place that
// merely looks alike gets that far, and to read the surroundings of a stored map is most of the work.
class MapLocalizer {
 public:
  MapLocalizer(const RelocalizationConfig& config, uint32_t seed) : config_(config), seed_(seed) {}

  // A status is one of reading the map.
  absl::StatusOr<MapLocalization> Locate(const MapSnapshot& map, const MappingCamera& camera,
                                         const SearchImage& image, const PlacePrior& prior) const;
  // In a map in memory; `version` becomes the view's.
  MapLocalization Locate(const Map& map, const PlaceMemory& places, const MappingCamera& camera,
                         const SearchImage& image, const PlacePrior& prior, uint64_t version) const;

 private:
  RelocalizationConfig config_;
  uint32_t seed_;
};

// Keyframes that see the points of the fix, those that see most first (of equal ones the smaller id).
std::vector<KeyFrameId> KeyFramesSeeing(const MapSnapshot& map, const MapFix& fix, size_t limit);

// Share of the matched points whose class is that of the image's keypoint. nullopt when no pair has classes
// on both sides.
std::optional<double> ClassAgreement(const MapFix& fix, const FrameFeatures& image);

}  // namespace semmap
