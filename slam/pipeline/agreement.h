#pragma once

#include <algorithm>

namespace semmap {

// How much of the map around a camera agrees with its pose: of the points that should be in sight, how many
// are seen where they should be. The near ones are counted once more: far points fit poses that are metres
// apart, and alone they say little about where the camera is. Without depth nothing counts as near, as the
// unit is unknown.
struct Agreement {
  int expected = 0;
  int inliers = 0;
  int near_expected = 0;
  int near_inliers = 0;

  double Share() const { return inliers / std::max(1.0, static_cast<double>(expected)); }
  // 1 where too few are near to tell.
  double NearShare() const {
    constexpr int kEnough = 20;
    return near_expected < kEnough ? 1.0 : static_cast<double>(near_inliers) / near_expected;
  }
  // The weaker of the two: what says against the pose counts.
  double Trust() const { return std::min(Share(), NearShare()); }
};

// What an agreement has to reach before a pose is believed.
struct AgreementLimits {
  int min_inliers = 50;
  // Of the points that should be in sight. Streets repeat themselves: a shop sign or a row of windows alone
  // gives tens of inliers and a fine pose, but nothing around it fits.
  double min_inlier_share = 0.1;
  // The same of those that are near, where that is known.
  double min_near_share = 0.1;

  bool Admit(const Agreement& agreement) const {
    return agreement.inliers >= min_inliers && agreement.Share() >= min_inlier_share &&
           agreement.NearShare() >= min_near_share;
  }
};

}  // namespace semmap
