#pragma once

#include <vector>

#include "slam/map/map.h"
#include "slam/map/map_delta.h"

namespace semmap {

// A map of its own, in its own frame (and unit, without depth), that may become part of a larger one; with the
// frames of the drive that made it, ascending. They hang on keyframes of `map`, or on such as were culled
// there.
struct MapPiece {
  Map map;
  std::vector<FramePose> frames;
};

}  // namespace semmap
