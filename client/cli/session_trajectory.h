#pragma once

#include <map>
#include <string>

#include "absl/status/statusor.h"
#include "client/client.h"
#include "slam/evaluation/trajectory.h"

namespace semmap::client {

// Poses of one session's frames by sequence number; frames without a pose are absent.
using SequencedPoses = std::map<uint64_t, StampedPose>;

// The newest poses that the server holds for a map, by session ("sessions/..."); `session` empty: of all.
// DATA_LOSS when the answer is malformed.
absl::StatusOr<std::map<std::string, SequencedPoses>> FetchTrajectories(Client& client,
                                                                        const std::string& map,
                                                                        const std::string& session);

// Only the frames with a pose, for the TUM format.
Trajectory WithHoles(const SequencedPoses& poses);

// One pose for each sequence number in [first, last], as the KITTI format needs, in which a pose's line is
// its frame: a frame without a pose repeats the last known one (identity before the first). `filled` counts
// them.
Trajectory WithoutHoles(const SequencedPoses& poses, uint64_t first, uint64_t last, uint64_t* filled);

}  // namespace semmap::client
