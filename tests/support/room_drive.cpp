#include "tests/support/room_drive.h"

#include "slam/common/time.h"
#include "tests/support/textured_room.h"

namespace semmap::testing {

FrameInput SeeRoom(const CameraRig& rig, const SE3& map_from_camera, int index) {
  const TexturedRoom room(3);
  FrameInput frame;
  frame.sequence = static_cast<uint64_t>(index + 1);
  frame.timestamp = FromSeconds(0.1 * index);
  frame.image =
      room.Render(rig.camera, map_from_camera, rig.sensor == SensorType::kRgbd ? &frame.depth : nullptr);
  if (rig.sensor == SensorType::kStereo) {
    const SE3 left_from_right(Eigen::Quaterniond::Identity(), {rig.baseline_m, 0, 0});
    frame.right = room.Render(rig.camera, map_from_camera * left_from_right);
  }
  return frame;
}

std::vector<FrameInput> DriveThroughRoom(SensorType sensor, int count, double step) {
  const CameraRig rig = SmallRig(sensor);
  std::vector<FrameInput> frames;
  for (const SE3& pose : GentleDrive(count, step))
    frames.push_back(SeeRoom(rig, pose, static_cast<int>(frames.size())));
  return frames;
}

}  // namespace semmap::testing
