#pragma once

#include "absl/status/statusor.h"
#include "client/sources/frame_source.h"
#include "semmap/v1/frame.pb.h"

namespace semmap::client {

// The service counts frames from 1, sources from 0.
inline uint64_t SequenceToSend(const SourceFrame& frame) { return frame.sequence + 1; }

// JPEG and PNG files go as they are; what a source decoded goes as raw pixels.
absl::StatusOr<v1::Frame> FrameMessage(SourceFrame frame);

}  // namespace semmap::client
