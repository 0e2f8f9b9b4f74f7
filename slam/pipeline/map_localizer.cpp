#include "slam/pipeline/map_localizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>

#include <Eigen/Eigenvalues>

#include "slam/common/status_macros.h"
#include "slam/pipeline/keyframe_matcher.h"

namespace semmap {
namespace {

// A pose is worth comparing with others from here on.
constexpr int kMinHypothesisInliers = 20;
// Poses so near each other, seen from the depth of what they look at, are one place.
constexpr double kSamePlaceShift = 0.15;
constexpr double kSamePlaceTurn = 10 * std::numbers::pi / 180;
// A keyframe stands where a pose is when it is nearer than so many times that depth and looks about the same
// way: trying it, too, would only find the same again.
constexpr double kNearKeyFrame = 0.5;
constexpr double kNearKeyFrameTurn = 35 * std::numbers::pi / 180;
// A keyframe shows a place also to a camera that looks another way.
constexpr double kKeyFrameTurn = 50 * std::numbers::pi / 180;

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Eigen::Vector3d ViewingDirection(const SE3& map_from_camera) {
  return map_from_camera.rotation() * Eigen::Vector3d::UnitZ();
}

// The prior for keyframes, which may stand beside what it allows: in the other lane, say. How far keyframes
// are apart is told by the nearest.
PlacePrior Widened(const MapSnapshot& map, PlacePrior prior) {
  if (prior.position) {
    double nearest = std::numeric_limits<double>::infinity();
    map.ForEachPose([&](const SE3& camera_from_map) {
      nearest = std::min(nearest, prior.position->DistanceTo(camera_from_map.Inverse().translation()));
    });
    prior.position->radius += std::max(prior.position->radius, 2 * nearest);
  }
  if (prior.heading)
    prior.heading->tolerance = std::min(std::numbers::pi, prior.heading->tolerance + kKeyFrameTurn);
  return prior;
}

// A pose that some place suggests.
struct Hypothesis {
  MapFix found;
  int matches = 0;
  double depth = 0;  // median of what it sees
};

double MedianDepth(const MapFix& found) {
  std::vector<double> depths;
  for (const int32_t point : found.fix.matches) {
    if (point >= 0) depths.push_back((found.fix.camera_from_map * found.view->positions[point]).z());
  }
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

bool IsSamePlace(const Hypothesis& a, const SE3& camera_from_map, double shift, double turn) {
  const SE3 difference = a.found.fix.camera_from_map * camera_from_map.Inverse();
  return difference.translation().norm() < shift * a.depth && difference.RotationAngle() < turn;
}

// The keyframes of a view serve to track on; here its points are enough.
LocalMapViewLimits PointsAround() {
  LocalMapViewLimits limits;
  limits.keyframes = 1;
  return limits;
}

// One search: collects poses that places suggest.
class Search {
 public:
  Search(const MapSnapshot& map, const MappingCamera& camera, const SearchImage& image, uint32_t seed)
      : map_(map), camera_(camera), image_(image) {
    // Weak poses count as well: as rivals, and as the reason of a failure.
    options_.limits = {kMinHypothesisInliers, 0, 0};
    options_.seed = seed;
  }

  // Whether a pose was found already where this keyframe stands.
  bool IsCovered(const SE3& camera_from_map) const {
    return std::any_of(hypotheses_.begin(), hypotheses_.end(), [&](const Hypothesis& known) {
      return IsSamePlace(known, camera_from_map, kNearKeyFrame, kNearKeyFrameTurn);
    });
  }

  absl::Status Try(KeyFrameId id, const PlaceCandidate& place, const std::vector<KeypointPair>& pairs) {
    const auto count = static_cast<int>(pairs.size());
    matches_ = std::max(matches_, count);
    if (count < options_.min_matches) {
      Fail(LocalizationFailure::kTooFewMatches);
      return absl::OkStatus();
    }
    std::shared_ptr<const LocalMapView> view;
    absl::Status status;
    ViewLocalization located =
        LocateInView(options_, camera_, map_.scale_info(), *place.view, pairs, image_, [&] {
          auto around = map_.ViewAround(id, PointsAround());
          status = around.status();
          if (around.ok()) view = *std::move(around);
          return view.get();
        });
    if (located.fix) {
      Add({std::move(view), *std::move(located.fix)}, count);
    } else {
      Fail(located.failure);
    }
    return status;
  }

  // Best first, refined, at most one for each place.
  absl::StatusOr<std::vector<Hypothesis>> TakeHypotheses() {
    std::vector<Hypothesis> distinct;
    Sort();
    for (Hypothesis& hypothesis : hypotheses_) {
      SEMMAP_RETURN_IF_ERROR(Refine(&hypothesis));
      const bool known = std::any_of(distinct.begin(), distinct.end(), [&](const Hypothesis& other) {
        return IsSamePlace(other, hypothesis.found.fix.camera_from_map, kSamePlaceShift, kSamePlaceTurn);
      });
      if (!known) distinct.push_back(std::move(hypothesis));
    }
    hypotheses_ = std::move(distinct);
    Sort();
    return std::move(hypotheses_);
  }

  bool empty() const { return hypotheses_.empty(); }
  int matches() const { return matches_; }
  LocalizationFailure failure() const { return failure_; }

 private:
  void Fail(LocalizationFailure failure) { failure_ = std::max(failure_, failure); }

  void Add(MapFix found, int matches) {
    const double depth = MedianDepth(found);
    hypotheses_.push_back({std::move(found), matches, depth});
  }

  void Sort() {
    std::stable_sort(hypotheses_.begin(), hypotheses_.end(), [](const Hypothesis& a, const Hypothesis& b) {
      return a.found.fix.agreement.inliers > b.found.fix.agreement.inliers;
    });
  }

  // The candidate need not be the keyframe that stands nearest: looks again from where the camera is.
  absl::Status Refine(Hypothesis* hypothesis) const {
    const auto seeing = KeyFramesSeeing(map_, hypothesis->found, 1);
    if (seeing.empty()) return absl::OkStatus();
    auto view = hypothesis->found.view;
    if (seeing.front() != view->reference().id) {
      SEMMAP_ASSIGN_OR_RETURN(view, map_.ViewAround(seeing.front(), PointsAround()));
      if (view == nullptr) return absl::OkStatus();
    }
    ViewLocalization again = LocateNear(options_, camera_, map_.scale_info(), *view,
                                        hypothesis->found.fix.camera_from_map, image_);
    if (!again.fix || again.agreement.inliers < hypothesis->found.fix.agreement.inliers)
      return absl::OkStatus();
    hypothesis->found = {std::move(view), *std::move(again.fix)};
    hypothesis->depth = MedianDepth(hypothesis->found);
    return absl::OkStatus();
  }

  const MapSnapshot& map_;
  const MappingCamera& camera_;
  const SearchImage& image_;
  ViewLocalizerOptions options_;
  std::vector<Hypothesis> hypotheses_;
  int matches_ = 0;
  LocalizationFailure failure_ = LocalizationFailure::kNoCandidates;
};

// How far the position is uncertain, as a share of the depth of what is seen.
double RelativeUncertainty(const Hypothesis& hypothesis) {
  const Eigen::Matrix3d covariance = hypothesis.found.fix.covariance.topLeftCorner<3, 3>();
  if (!covariance.allFinite() || hypothesis.depth <= 0) return std::numeric_limits<double>::infinity();
  const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly)
                             .eigenvalues()
                             .maxCoeff();
  return std::sqrt(std::max(0.0, largest)) / hypothesis.depth;
}

absl::Status TryAll(const std::vector<PlaceMatch>& candidates, const MapSnapshot& map,
                    const MappingCamera& camera, const SearchImage& image,
                    const PlaceDescription& description, size_t exhaustive, Search* search) {
  for (const PlaceMatch& candidate : candidates) {
    if (search->IsCovered(*map.FindPose(candidate.keyframe))) continue;
    SEMMAP_ASSIGN_OR_RETURN(const auto place, map.Candidate(candidate.keyframe));
    if (!place) continue;
    SEMMAP_RETURN_IF_ERROR(
        search->Try(candidate.keyframe, *place,
                    MatchWithinNodes(camera.association, *place->view, place->view->reference(),
                                     *place->nodes, image.features, description.nodes)));
  }
  // Seen from elsewhere, corners change their words before they change their neighbours.
  for (size_t i = 0; i < std::min(candidates.size(), exhaustive) && search->empty(); ++i) {
    SEMMAP_ASSIGN_OR_RETURN(const auto place, map.Candidate(candidates[i].keyframe));
    if (!place) continue;
    SEMMAP_RETURN_IF_ERROR(search->Try(
        candidates[i].keyframe, *place,
        MatchExhaustively(camera.association, *place->view, place->view->reference(), image.features)));
  }
  return absl::OkStatus();
}

// Whether the best of these places, best first and not none, is to be believed.
void Judge(const RelocalizationConfig& config, const std::vector<Hypothesis>& hypotheses,
           const PlacePrior& prior, MapLocalization* result) {
  const Hypothesis& best = hypotheses.front();
  const ViewFix& fix = best.found.fix;
  result->matches = best.matches;
  result->agreement = fix.agreement;
  if (hypotheses.size() > 1) result->rival_inliers = hypotheses[1].found.fix.agreement.inliers;
  if (!config.limits.Admit(fix.agreement)) {
    result->failure = LocalizationFailure::kTooFewInliers;
  } else if (RelativeUncertainty(best) > config.max_uncertainty ||
             result->rival_inliers > config.max_rival_share * fix.agreement.inliers) {
    result->failure = LocalizationFailure::kDegeneratePose;
  } else if (!prior.Admits(fix.camera_from_map.Inverse())) {
    result->failure = LocalizationFailure::kNoCandidates;
  } else {
    result->failure = LocalizationFailure::kNone;
    result->found = best.found;
  }
}

}  // namespace

double PlacePrior::Position::DistanceTo(const Eigen::Vector3d& point_in_map) const {
  const Eigen::Vector3d apart = point_in_map - in_map;
  return (apart - up_in_map.dot(apart) * up_in_map).norm();
}

bool PlacePrior::Admits(const SE3& map_from_camera) const {
  if (position && position->DistanceTo(map_from_camera.translation()) > position->radius) return false;
  return !heading || AngleBetween(ViewingDirection(map_from_camera), heading->in_map) <= heading->tolerance;
}

absl::StatusOr<MapLocalization> MapLocalizer::Locate(const MapSnapshot& map, const MappingCamera& camera,
                                                     const SearchImage& image,
                                                     const PlacePrior& prior) const {
  MapLocalization result;
  if (map.places() == nullptr) return result;
  const PlaceDescription description = map.Describe(image.features);
  const PlacePrior near_prior = Widened(map, prior);
  const auto candidates =
      map.places()->Query(description.words, static_cast<size_t>(config_.candidates), 0, [&](KeyFrameId id) {
        const std::optional<SE3> camera_from_map = map.FindPose(id);
        return !camera_from_map || !near_prior.Admits(camera_from_map->Inverse());
      });
  result.candidates = static_cast<int>(candidates.size());

  Search search(map, camera, image, seed_);
  SEMMAP_RETURN_IF_ERROR(TryAll(candidates, map, camera, image, description,
                                static_cast<size_t>(config_.exhaustive_candidates), &search));
  result.matches = search.matches();
  result.failure = search.failure();
  SEMMAP_ASSIGN_OR_RETURN(const std::vector<Hypothesis> hypotheses, search.TakeHypotheses());
  if (!hypotheses.empty()) Judge(config_, hypotheses, prior, &result);
  return result;
}

MapLocalization MapLocalizer::Locate(const Map& map, const PlaceMemory& places, const MappingCamera& camera,
                                     const SearchImage& image, const PlacePrior& prior,
                                     uint64_t version) const {
  return *Locate(MapInMemory(map, places, version), camera, image, prior);
}

std::vector<KeyFrameId> KeyFramesSeeing(const MapSnapshot& map, const MapFix& fix, size_t limit) {
  std::unordered_map<KeyFrameId, int, IdHash> counts;
  for (const int32_t index : fix.fix.matches) {
    if (index >= 0)
      map.ForEachObserver(fix.view->ids[index], [&](KeyFrameId observer) { ++counts[observer]; });
  }
  std::vector<std::pair<int, KeyFrameId>> ranked;
  for (const auto& [id, count] : counts) ranked.emplace_back(-count, id);
  std::sort(ranked.begin(), ranked.end());
  std::vector<KeyFrameId> ids;
  for (size_t i = 0; i < std::min(limit, ranked.size()); ++i) ids.push_back(ranked[i].second);
  return ids;
}

std::optional<double> ClassAgreement(const MapFix& fix, const FrameFeatures& image) {
  int pairs = 0;
  int agreeing = 0;
  for (size_t i = 0; i < fix.fix.matches.size(); ++i) {
    const uint8_t seen = image.keypoints[i].semantic_class;
    if (fix.fix.matches[i] < 0 || seen == kUnknownClass) continue;
    const uint8_t known = fix.view->classes[fix.fix.matches[i]];
    if (known == kUnknownClass) continue;
    ++pairs;
    if (known == seen) ++agreeing;
  }
  if (pairs == 0) return std::nullopt;
  return static_cast<double>(agreeing) / pairs;
}

}  // namespace semmap
