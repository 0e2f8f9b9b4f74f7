#pragma once

#include <vector>

#include "slam/geometry/camera.h"
#include "slam/pipeline/frame.h"

namespace semmap::testing {

// What a camera sees in the TexturedRoom of seed 3: the frame of that index, ten a second, from sequence 1
// and time 0 on. Depth only comes if the sensor has it.
FrameInput SeeRoom(const CameraRig& rig, const SE3& map_from_camera, int index);

// What a SmallRig sees there on a GentleDrive.
std::vector<FrameInput> DriveThroughRoom(SensorType sensor, int count, double step);

}  // namespace semmap::testing
