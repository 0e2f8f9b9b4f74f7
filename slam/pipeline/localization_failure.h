#pragma once

namespace semmap {

// Why an image was not found in a map, from the earliest obstacle to the last.
enum class LocalizationFailure {
  kNone,            // it was found
  kNoCandidates,    // no keyframe looks like it
  kTooFewMatches,   // descriptors do not agree with any candidate's points
  kDegeneratePose,  // no pose explains enough of the matches
  kTooFewInliers,   // a pose exists, but too little of the map agrees with it
};

}  // namespace semmap
