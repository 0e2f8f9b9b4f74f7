#pragma once

#include "absl/status/statusor.h"
#include "slam/geometry/camera.h"
#include "slam/geometry/se3.h"
#include "storage/byte_buffer.h"

// Packed forms of poses and camera rigs. Exact: what is decoded equals what was encoded, bit for bit.
// Decoders answer DATA_LOSS for anything that no encoder wrote.
namespace semmap::storage {

// Translation x y z, then the unit quaternion x y z w, as doubles.
constexpr size_t kPackedPoseSize = 7 * sizeof(double);

std::array<uint8_t, kPackedPoseSize> EncodePose(const SE3& pose);
absl::StatusOr<SE3> DecodePose(BlobView bytes);

Blob EncodeSim3(const Sim3& transform);
absl::StatusOr<Sim3> DecodeSim3(BlobView bytes);

Blob EncodeRig(const CameraRig& rig);
absl::StatusOr<CameraRig> DecodeRig(BlobView bytes);

}  // namespace semmap::storage
