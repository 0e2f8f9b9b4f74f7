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
  return message;
}

}  // namespace semmap::client
