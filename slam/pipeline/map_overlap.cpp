#include "slam/pipeline/map_overlap.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

namespace semmap {
namespace {

// Two keyframes that were found agree when each is put about where it was found by what the other one tells:
// within this share of the depth of what it sees, and, as both maps have drifted, this share of the distance
// between the two; turned alike, and with about the same scale.
constexpr double kAgreeingShift = 0.15;
constexpr double kAgreeingDrift = 0.05;
constexpr double kAgreeingTurn = 8 * std::numbers::pi / 180;
constexpr double kAgreeingScaleLog = 0.2;
// Keyframes of the target in which those of the source must be found: one that looks like many tells nothing.
constexpr size_t kMinPlaces = 2;

// What one keyframe of the source that was found tells of the two maps.
struct Sighting {
  Loop link;
  Sim3 target_from_source;
  Eigen::Vector3d center_in_source;
  double depth = 0;  // median of what it sees, in units of the target
};

double MedianDepth(const Map& map, const Loop& link) {
  const KeyFrame& old = *map.FindKeyFrame(link.old);
  std::vector<double> depths;
  for (const auto& [point, keypoint] : link.seen)
    depths.push_back((old.camera_from_map * map.FindPoint(point)->position_in_map).norm());
  if (depths.empty()) return 0;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

Sighting MakeSighting(const Map& map, Loop link) {
  Sighting sighting;
  const Sim3 target_from_old{1, map.FindKeyFrame(link.old)->camera_from_map.Inverse()};
  const Sim3 current_from_source{1, map.FindKeyFrame(link.current)->camera_from_map};
  sighting.target_from_source = target_from_old * link.old_from_current * current_from_source;
  sighting.center_in_source = map.FindKeyFrame(link.current)->Center();
  sighting.depth = MedianDepth(map, link);
  sighting.link = std::move(link);
  return sighting;
}

// How far what `teller` tells moves the other one from where it was found.
double Shift(const Sighting& teller, const Sighting& other) {
  const Eigen::Vector3d& center = other.center_in_source;
  return (teller.target_from_source * center - other.target_from_source * center).norm();
}

bool Agree(const Sighting& a, const Sighting& b) {
  const SE3& a_rigid = a.target_from_source.rigid;
  const SE3& b_rigid = b.target_from_source.rigid;
  if (a_rigid.rotation().angularDistance(b_rigid.rotation()) > kAgreeingTurn) return false;
  if (std::abs(std::log(a.target_from_source.scale / b.target_from_source.scale)) > kAgreeingScaleLog)
    return false;
  const double distance = a.target_from_source.scale * (a.center_in_source - b.center_in_source).norm();
  const double allowed = kAgreeingShift * std::min(a.depth, b.depth) + kAgreeingDrift * distance;
  return Shift(a, b) <= allowed && Shift(b, a) <= allowed;
}

// Indices of those of `among` that agree with one of them, itself included.
std::vector<size_t> Supporters(const std::vector<Sighting>& sightings, const std::vector<size_t>& among,
                               size_t teller) {
  std::vector<size_t> supporters;
  for (const size_t i : among) {
    if (i == teller || Agree(sightings[teller], sightings[i])) supporters.push_back(i);
  }
  return supporters;
}

// The most that are of one mind; of equally many the first.
std::vector<size_t> LargestParty(const std::vector<Sighting>& sightings, const std::vector<size_t>& among) {
  std::vector<size_t> largest;
  for (const size_t teller : among) {
    std::vector<size_t> party = Supporters(sightings, among, teller);
    if (party.size() > largest.size()) largest = std::move(party);
  }
  return largest;
}

// The member that moves all others least.
size_t MostCentral(const std::vector<Sighting>& sightings, const std::vector<size_t>& party) {
  size_t central = party.front();
  double least = std::numeric_limits<double>::infinity();
  for (const size_t teller : party) {
    double sum = 0;
    for (const size_t other : party) sum += Shift(sightings[teller], sightings[other]);
    if (sum >= least) continue;
    least = sum;
    central = teller;
  }
  return central;
}

std::vector<size_t> Without(const std::vector<size_t>& all, const std::vector<size_t>& party) {
  std::vector<size_t> rest;
  std::set_difference(all.begin(), all.end(), party.begin(), party.end(), std::back_inserter(rest));
  return rest;
}

void TakeLargestParty(std::vector<Sighting> sightings, MapOverlap* overlap) {
  std::vector<size_t> all(sightings.size());
  for (size_t i = 0; i < all.size(); ++i) all[i] = i;
  overlap->found = static_cast<int>(all.size());
  if (all.empty()) return;
  const std::vector<size_t> party = LargestParty(sightings, all);
  overlap->rivals = static_cast<int>(LargestParty(sightings, Without(all, party)).size());
  const Sighting& central = sightings[MostCentral(sightings, party)];
  overlap->target_from_source = central.target_from_source;
  overlap->depth = central.depth;
  for (const size_t i : party) overlap->links.push_back(std::move(sightings[i].link));
}

// Where in the target the keyframe's place is.
std::optional<Loop> FindPlace(const SlamConfig& config, const MappingCamera& camera,
                              const PlaceMemory& places, const Map& map, KeyFrameId last_of_target,
                              KeyFrameId keyframe) {
  const auto candidates =
      places.index().Query(*places.WordsOf(keyframe), static_cast<size_t>(config.merge.candidates), 0,
                           [&](KeyFrameId id) { return id > last_of_target; });
  for (const PlaceMatch& candidate : candidates) {
    auto loop = VerifyLoop(config.loop, static_cast<uint32_t>(config.seed), camera, places, map,
                           candidate.keyframe, keyframe);
    if (loop) return loop;
  }
  return std::nullopt;
}

}  // namespace

bool MapOverlap::IsSound(const MergeConfig& config) const {
  std::set<KeyFrameId> seen_places;
  for (const Loop& link : links) seen_places.insert(link.old);
  return links.size() >= static_cast<size_t>(config.min_keyframes) && seen_places.size() >= kMinPlaces &&
         rivals <= config.max_rival_share * static_cast<double>(links.size());
}

bool MapOverlap::IsConfirmedBy(const SE3& source_from_camera, const SE3& target_from_camera) const {
  if (links.empty() || rivals > 0) return false;
  const Eigen::Quaterniond rotation = target_from_source.rigid.rotation() * source_from_camera.rotation();
  const Eigen::Vector3d center = target_from_source * source_from_camera.translation();
  return rotation.angularDistance(target_from_camera.rotation()) <= kAgreeingTurn &&
         (center - target_from_camera.translation()).norm() <= kAgreeingShift * depth;
}

absl::StatusOr<MapOverlap> FindOverlap(const SlamConfig& config, const MappingCamera& camera,
                                       const PlaceMemory& places, const Map& map, KeyFrameId last_of_target,
                                       const StepVisitor& visit) {
  MapOverlap overlap;
  if (!places.enabled()) return overlap;
  std::vector<KeyFrameId> sources;
  for (const auto& [id, keyframe] : map.keyframes()) {
    if (id > last_of_target) sources.push_back(id);
  }
  std::sort(sources.begin(), sources.end());
  overlap.keyframes = static_cast<int>(sources.size());
  std::vector<Sighting> sightings;
  for (size_t i = 0; i < sources.size(); ++i) {
    if (visit && !visit(static_cast<double>(i) / static_cast<double>(sources.size())))
      return absl::CancelledError("the search for common places was cancelled");
    auto link = FindPlace(config, camera, places, map, last_of_target, sources[i]);
    if (link) sightings.push_back(MakeSighting(map, *std::move(link)));
  }
  TakeLargestParty(std::move(sightings), &overlap);
  return overlap;
}

}  // namespace semmap
