#include "client/cli/frame_message.h"

#include "client/image.h"
#include "slam/common/status_macros.h"

namespace semmap::client {
namespace {

absl::StatusOr<v1::Image> ImageMessage(SourceImage image) {
  if (image.encoding == ImageEncoding::kNone) return RawImage(image.pixels);
  return FileImage(std::move(image.encoded));
}

}  // namespace

absl::StatusOr<v1::Frame> FrameMessage(SourceFrame frame) {
  v1::Frame message;
  message.set_sequence(SequenceToSend(frame));
  message.set_timestamp_ns(frame.timestamp);
  SEMMAP_ASSIGN_OR_RETURN(*message.mutable_image(), ImageMessage(std::move(frame.image)));
  if (!frame.right.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(*message.mutable_right(), ImageMessage(std::move(frame.right)));
  }
  if (!frame.depth.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(*message.mutable_depth(), ImageMessage(std::move(frame.depth)));
  }
  if (!frame.class_mask.empty()) {
    SEMMAP_ASSIGN_OR_RETURN(*message.mutable_class_mask(), ImageMessage(std::move(frame.class_mask)));
  }
  if (frame.wheel_speed_m_s) message.mutable_odometry()->set_speed_m_s(*frame.wheel_speed_m_s);
  if (frame.gnss) {
    v1::GnssFix* fix = message.mutable_gnss();
    fix->mutable_position()->set_latitude_deg(frame.gnss->latitude_deg);
    fix->mutable_position()->set_longitude_deg(frame.gnss->longitude_deg);
    fix->mutable_position()->set_altitude_m(frame.gnss->altitude_m);
    fix->set_horizontal_accuracy_m(frame.gnss->accuracy_m);
    // Receivers are about twice as wrong upwards.
    fix->set_vertical_accuracy_m(2 * frame.gnss->accuracy_m);
  }
  return message;
}

}  // namespace semmap::client
