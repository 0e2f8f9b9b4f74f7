#pragma once

#include <map>
#include <vector>

#include "slam/map/map_delta.h"

namespace semmap {

// Remembers where the keyframes of one session were when they were made, hence where the frames near them
// were reported to be, and tells what became of that. Fed with every delta of the map; a value.
class CorrectionLog {
 public:
  // Other sessions that make the same map have deltas, too: their new keyframes are not `own`.
  void Note(const MapDelta& delta, bool own = true);
  // Such a keyframe came from another frame, of which one unit is `scale` of the map: what was reported near
  // it was reported there. Before the delta that adds it.
  void NoteReportedElsewhere(KeyFrameId id, uint64_t sequence, const SE3& elsewhere_from_camera,
                             double scale);
  // One for each keyframe of the map, for the frames from it up to the next; the last one's end is open.
  std::vector<PoseCorrection> Corrections() const;

 private:
  struct Entry {
    uint64_t sequence = 0;
    SE3 map_from_camera_then;
    SE3 map_from_camera_now;
    double scale = 1;
  };
  std::map<KeyFrameId, Entry> keyframes_;
};

}  // namespace semmap
