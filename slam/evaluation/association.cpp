#include "slam/evaluation/association.h"

#include <algorithm>
#include <cstdlib>
#include <tuple>

#include "absl/strings/str_cat.h"

namespace semmap {
namespace {

// How many entries on either side of the nearest one may still become its partner.
constexpr size_t kNeighbours = 8;

struct Candidate {
  TimestampNs difference = 0;
  size_t first = 0;
  size_t second = 0;
};

std::vector<Candidate> CollectCandidates(const std::vector<TimestampNs>& first,
                                         const std::vector<TimestampNs>& second, TimestampNs max_difference) {
  std::vector<Candidate> candidates;
  for (size_t j = 0; j < second.size(); ++j) {
    const auto nearest = std::lower_bound(first.begin(), first.end(), second[j]) - first.begin();
    const size_t middle = static_cast<size_t>(nearest);
    const size_t begin = middle > kNeighbours ? middle - kNeighbours : 0;
    const size_t end = std::min(first.size(), middle + kNeighbours);
    for (size_t i = begin; i < end; ++i) {
      const TimestampNs difference = std::abs(first[i] - second[j]);
      if (difference <= max_difference) candidates.push_back({difference, i, j});
    }
  }
  return candidates;
}

std::vector<TimestampNs> TimesOf(const Trajectory& trajectory) {
  std::vector<TimestampNs> times;
  times.reserve(trajectory.size());
  for (const StampedPose& pose : trajectory.poses) times.push_back(pose.timestamp);
  return times;
}

PosePair MakePair(const Trajectory& reference, size_t i, const Trajectory& estimate, size_t j) {
  return {estimate.poses[j].timestamp, i, j, reference.poses[i].map_from_camera,
          estimate.poses[j].map_from_camera};
}

}  // namespace

std::vector<TimeMatch> MatchTimes(const std::vector<TimestampNs>& first,
                                  const std::vector<TimestampNs>& second, double max_difference_s) {
  std::vector<Candidate> candidates = CollectCandidates(first, second, FromSeconds(max_difference_s));
  std::sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) {
    return std::tie(a.difference, a.first, a.second) < std::tie(b.difference, b.first, b.second);
  });
  std::vector<char> first_used(first.size(), 0);
  std::vector<char> second_used(second.size(), 0);
  std::vector<TimeMatch> matches;
  for (const Candidate& candidate : candidates) {
    if (first_used[candidate.first] != 0 || second_used[candidate.second] != 0) continue;
    first_used[candidate.first] = 1;
    second_used[candidate.second] = 1;
    matches.push_back({candidate.first, candidate.second});
  }
  std::sort(matches.begin(), matches.end(),
            [](const TimeMatch& a, const TimeMatch& b) { return a.second < b.second; });
  return matches;
}

absl::StatusOr<std::vector<PosePair>> AssociateByTime(const Trajectory& reference, const Trajectory& estimate,
                                                      double max_difference_s) {
  if (!reference.timed || !estimate.timed) {
    return absl::InvalidArgumentError(
        absl::StrCat("the ", reference.timed ? "estimate" : "reference", " has no times to associate by"));
  }
  std::vector<PosePair> pairs;
  for (const TimeMatch& match : MatchTimes(TimesOf(reference), TimesOf(estimate), max_difference_s)) {
    pairs.push_back(MakePair(reference, match.first, estimate, match.second));
  }
  if (pairs.empty()) {
    return absl::FailedPreconditionError(absl::StrCat("no pose of the estimate lies within ",
                                                      max_difference_s,
                                                      " s of one of the reference: other clocks?"));
  }
  return pairs;
}

absl::StatusOr<std::vector<PosePair>> AssociateByIndex(const Trajectory& reference,
                                                       const Trajectory& estimate) {
  if (reference.size() != estimate.size()) {
    return absl::InvalidArgumentError(absl::StrCat("the reference has ", reference.size(),
                                                   " poses, the estimate ", estimate.size(),
                                                   ": without times they cannot be associated"));
  }
  std::vector<PosePair> pairs;
  pairs.reserve(reference.size());
  for (size_t i = 0; i < reference.size(); ++i) pairs.push_back(MakePair(reference, i, estimate, i));
  return pairs;
}

}  // namespace semmap
