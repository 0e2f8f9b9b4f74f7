#include "slam/pipeline/map_localizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_map>

#include <Eigen/Eigenvalues>

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
PlacePrior Widened(const Map& map, PlacePrior prior) {
  if (prior.position) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& [id, keyframe] : map.keyframes())
      nearest = std::min(nearest, prior.position->DistanceTo(keyframe.Center()));
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

// One search: collects poses that places suggest.
class Search {
 public:
  Search(const Map& map, const MappingCamera& camera, const SearchImage& image, uint32_t seed,
         uint64_t version)
      : map_(map), camera_(camera), image_(image), version_(version) {
    // Weak poses count as well: as rivals, and as the reason of a failure.
    options_.min_inliers = kMinHypothesisInliers;
    options_.min_inlier_share = 0;
    options_.min_near_share = 0;
    options_.seed = seed;
  }

  // Whether a pose was found already where this keyframe stands.
  bool IsCovered(const KeyFrame& keyframe) const {
    return std::any_of(hypotheses_.begin(), hypotheses_.end(), [&](const Hypothesis& known) {
      return IsSamePlace(known, keyframe.camera_from_map, kNearKeyFrame, kNearKeyFrameTurn);
    });
  }

  void Try(const KeyFrame& keyframe, const std::vector<KeypointPair>& pairs) {
    const auto count = static_cast<int>(pairs.size());
    matches_ = std::max(matches_, count);
    if (count < options_.min_matches) {
      Fail(LocalizationFailure::kTooFewMatches);
      return;
    }
    const auto view = MakeLocalMapView(map_, keyframe.id, version_, LocalMapViewLimits());
    ViewLocalization located =
        LocateInView(options_, camera_, map_.scale_info(), *view, view->reference(), pairs, image_);
    if (located.fix) {
      Add({view, *std::move(located.fix)}, count);
    } else {
      Fail(located.failure);
    }
  }

  // Best first, refined, at most one for each place.
  std::vector<Hypothesis> TakeHypotheses() {
    std::vector<Hypothesis> distinct;
    Sort();
    for (Hypothesis& hypothesis : hypotheses_) {
      Refine(&hypothesis);
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
  void Refine(Hypothesis* hypothesis) const {
    const auto seeing = KeyFramesSeeing(map_, hypothesis->found, 1);
    if (seeing.empty()) return;
    auto view = hypothesis->found.view;
    if (seeing.front() != view->reference().id)
      view = MakeLocalMapView(map_, seeing.front(), version_, LocalMapViewLimits());
    ViewLocalization again = LocateNear(options_, camera_, map_.scale_info(), *view,
                                        hypothesis->found.fix.camera_from_map, image_);
    if (!again.fix || again.agreement.inliers < hypothesis->found.fix.agreement.inliers) return;
    hypothesis->found = {std::move(view), *std::move(again.fix)};
    hypothesis->depth = MedianDepth(hypothesis->found);
  }

  const Map& map_;
  const MappingCamera& camera_;
  const SearchImage& image_;
  const uint64_t version_;
  ViewLocalizerOptions options_;
  std::vector<Hypothesis> hypotheses_;
  int matches_ = 0;
  LocalizationFailure failure_ = LocalizationFailure::kNoCandidates;
};

bool IsEnough(const RelocalizationConfig& config, const Agreement& agreement) {
  return agreement.inliers >= config.min_inliers && agreement.Share() >= config.min_inlier_share &&
         agreement.NearShare() >= config.min_near_share;
}

// How far the position is uncertain, as a share of the depth of what is seen.
double RelativeUncertainty(const Hypothesis& hypothesis) {
  const Eigen::Matrix3d covariance = hypothesis.found.fix.covariance.topLeftCorner<3, 3>();
  if (!covariance.allFinite() || hypothesis.depth <= 0) return std::numeric_limits<double>::infinity();
  const double largest = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance, Eigen::EigenvaluesOnly)
                             .eigenvalues()
                             .maxCoeff();
  return std::sqrt(std::max(0.0, largest)) / hypothesis.depth;
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

MapLocalization MapLocalizer::Locate(const Map& map, const PlaceMemory& places, const MappingCamera& camera,
                                     const SearchImage& image, const PlacePrior& prior,
                                     uint64_t version) const {
  MapLocalization result;
  if (!places.enabled()) return result;
  const PlaceDescription description = places.Describe(image.features);
  const PlacePrior near_prior = Widened(map, prior);
  const auto candidates =
      places.index().Query(description.words, static_cast<size_t>(config_.candidates), 0, [&](KeyFrameId id) {
        const KeyFrame* keyframe = map.FindKeyFrame(id);
        return keyframe == nullptr || !near_prior.Admits(keyframe->camera_from_map.Inverse());
      });
  result.candidates = static_cast<int>(candidates.size());

  Search search(map, camera, image, seed_, version);
  for (const PlaceMatch& candidate : candidates) {
    const KeyFrame& keyframe = *map.FindKeyFrame(candidate.keyframe);
    if (search.IsCovered(keyframe)) continue;
    search.Try(keyframe, MatchWithinNodes(camera.association, map, keyframe, *places.NodesOf(keyframe.id),
                                          image.features, description.nodes));
  }
  // Seen from elsewhere, corners change their words before they change their neighbours.
  const size_t exhaustive = std::min(candidates.size(), static_cast<size_t>(config_.exhaustive_candidates));
  for (size_t i = 0; i < exhaustive && search.empty(); ++i) {
    const KeyFrame& keyframe = *map.FindKeyFrame(candidates[i].keyframe);
    search.Try(keyframe, MatchExhaustively(camera.association, map, keyframe, image.features));
  }
  result.matches = search.matches();
  result.failure = search.failure();
  std::vector<Hypothesis> hypotheses = search.TakeHypotheses();
  if (hypotheses.empty()) return result;

  Hypothesis& best = hypotheses.front();
  const ViewFix& fix = best.found.fix;
  result.matches = best.matches;
  result.agreement = fix.agreement;
  if (hypotheses.size() > 1) result.rival_inliers = hypotheses[1].found.fix.agreement.inliers;
  if (!IsEnough(config_, fix.agreement)) {
    result.failure = LocalizationFailure::kTooFewInliers;
  } else if (RelativeUncertainty(best) > config_.max_uncertainty ||
             result.rival_inliers > config_.max_rival_share * fix.agreement.inliers) {
    result.failure = LocalizationFailure::kDegeneratePose;
  } else if (!prior.Admits(fix.camera_from_map.Inverse())) {
    result.failure = LocalizationFailure::kNoCandidates;
  } else {
    result.failure = LocalizationFailure::kNone;
    result.found = std::move(best.found);
  }
  return result;
}

std::vector<KeyFrameId> KeyFramesSeeing(const Map& map, const MapFix& fix, size_t limit) {
  std::unordered_map<KeyFrameId, int, IdHash> counts;
  for (const int32_t index : fix.fix.matches) {
    if (index < 0) continue;
    for (const Observation& seen : map.FindPoint(fix.view->ids[index])->observations) ++counts[seen.keyframe];
  }
  std::vector<std::pair<int, KeyFrameId>> ranked;
  for (const auto& [id, count] : counts) ranked.emplace_back(-count, id);
  std::sort(ranked.begin(), ranked.end());
  std::vector<KeyFrameId> ids;
  for (size_t i = 0; i < std::min(limit, ranked.size()); ++i) ids.push_back(ranked[i].second);
  return ids;
}

std::optional<double> ClassAgreement(const Map& map, const MapFix& fix, const FrameFeatures& image) {
  int pairs = 0;
  int agreeing = 0;
  for (size_t i = 0; i < fix.fix.matches.size(); ++i) {
    const uint8_t seen = image.keypoints[i].semantic_class;
    if (fix.fix.matches[i] < 0 || seen == kUnknownClass) continue;
    const uint8_t known = map.FindPoint(fix.view->ids[fix.fix.matches[i]])->semantic_class;
    if (known == kUnknownClass) continue;
    ++pairs;
    if (known == seen) ++agreeing;
  }
  if (pairs == 0) return std::nullopt;
  return static_cast<double>(agreeing) / pairs;
}

}  // namespace semmap
