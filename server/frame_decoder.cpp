#include "server/frame_decoder.h"

#include "absl/strings/str_cat.h"
#include "server/error_reasons.h"
#include "server/image_decoder.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

absl::Status CheckPresence(bool present, bool wanted, const char* field, uint64_t sequence) {
  if (present == wanted) return absl::OkStatus();
  const v1::ErrorReason reason = wanted ? v1::ERROR_REASON_IMAGE_MISSING : v1::ERROR_REASON_IMAGE_UNEXPECTED;
  return Error(reason, absl::StrCat("frame ", sequence, wanted ? " lacks " : " has no use for ", field),
               {{"field", field}, {"sequence", std::to_string(sequence)}});
}

}  // namespace

absl::Status CheckImagesPresent(const v1::Frame& frame, SensorType sensor) {
  const uint64_t sequence = frame.sequence();
  SEMMAP_RETURN_IF_ERROR(CheckPresence(frame.has_image(), true, "image", sequence));
  SEMMAP_RETURN_IF_ERROR(CheckPresence(frame.has_right(), sensor == SensorType::kStereo, "right", sequence));
  return CheckPresence(frame.has_depth(), sensor == SensorType::kRgbd, "depth", sequence);
}

absl::StatusOr<FrameInput> DecodeFrame(const v1::Frame& frame, const CameraRig& rig, bool with_colour) {
  SEMMAP_RETURN_IF_ERROR(CheckImagesPresent(frame, rig.sensor));
  const uint64_t sequence = frame.sequence();
  const cv::Size size(rig.camera.width, rig.camera.height);
  FrameInput input;
  input.sequence = sequence;
  input.timestamp = frame.timestamp_ns();
  if (with_colour && !frame.has_class_mask()) {
    SEMMAP_ASSIGN_OR_RETURN(ColourImage image, DecodeColourImage(frame.image(), size, "image", sequence));
    input.image = std::move(image.grey);
    input.colour = std::move(image.colour);
  } else {
    SEMMAP_ASSIGN_OR_RETURN(input.image,
                            DecodeImage(frame.image(), ImageRole::kGrey, size, "image", sequence));
  }
  if (frame.has_right()) {
    SEMMAP_ASSIGN_OR_RETURN(input.right,
                            DecodeImage(frame.right(), ImageRole::kGrey, size, "right", sequence));
  }
  if (frame.has_depth()) {
    SEMMAP_ASSIGN_OR_RETURN(input.depth,
                            DecodeImage(frame.depth(), ImageRole::kDepth, size, "depth", sequence));
  }
  if (frame.has_class_mask()) {
    SEMMAP_ASSIGN_OR_RETURN(input.class_mask, DecodeImage(frame.class_mask(), ImageRole::kClassMask, size,
                                                          "class_mask", sequence));
  }
  return input;
}

}  // namespace semmap::server
