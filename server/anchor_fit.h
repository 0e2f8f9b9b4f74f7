#pragma once

#include <span>

#include "absl/status/statusor.h"
#include "server/gnss_track.h"
#include "slam/geometry/se3.h"
#include "storage/map_store.h"

namespace semmap::server {

// A fix and where the map has the camera of its frame.
struct GnssMatch {
  GnssSample fix;
  SE3 map_from_camera;
};

// The anchor that brings the cameras nearest to the fixes (least squares, Umeyama's closed form), with a
// scale of its own unless the map's is known. The antenna is taken to be at the camera: a metre between them
// is less than the error of a fix. A drive that is nearly straight leaves open how the map leans to its
// sides; then up is where the cameras' images have it, on average.
//
// FAILED_PRECONDITION when there are fewer than ten fixes, the vehicle has not gone several times as far as
// the fixes are wrong, or the fixes are not of the drive (errors of several times their accuracy).
absl::StatusOr<storage::GeoAnchor> FitAnchor(std::span<const GnssMatch> matches, bool scale_known);

}  // namespace semmap::server
