#include "server/gnss_track.h"

#include <cmath>

namespace semmap::server {
namespace {

constexpr size_t kMaxSamples = 4096;

bool IsFix(const v1::GnssFix& fix) {
  // Written so that not-a-number fails.
  return fix.has_position() && std::abs(fix.position().latitude_deg()) <= 90 &&
         std::abs(fix.position().longitude_deg()) <= 180 && std::isfinite(fix.position().altitude_m()) &&
         fix.horizontal_accuracy_m() > 0 && std::isfinite(fix.horizontal_accuracy_m());
}

}  // namespace

void GnssTrack::Add(uint64_t sequence, const v1::GnssFix& fix) {
  if (!IsFix(fix) || seen_++ % stride_ != 0) return;
  const v1::GeoPosition& position = fix.position();
  samples_.push_back({sequence, position.latitude_deg(), position.longitude_deg(), position.altitude_m(),
                      fix.horizontal_accuracy_m()});
  if (samples_.size() < kMaxSamples) return;
  for (size_t i = 0; 2 * i < samples_.size(); ++i) samples_[i] = samples_[2 * i];
  samples_.resize((samples_.size() + 1) / 2);
  stride_ *= 2;
}

}  // namespace semmap::server
