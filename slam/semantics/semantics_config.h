#pragma once

#include <string>
#include <vector>

#include "slam/common/fwd.h"
#include "slam/semantics/class_votes.h"
#include "slam/semantics/taxonomy.h"

namespace semmap {

// What the pipeline makes of the classes of pixels: each part of the paper's section 4 is a switch. Without
// class masks none of them changes anything.
struct SemanticsConfig {
  SemanticsConfig();

  // Class masks are used at all.
  bool enabled = true;
  // Keypoints whose class is less probable have none.
  double min_confidence = 0.0;
  // A corner in the sky with something else within so many pixels (of its pyramid level) belongs to that:
  // corners on the rim are made by what stands before the sky, and are as good as any. 0: it is taken for
  // sky, as in the paper.
  double sky_rim_px = 3.0;
  // A corner with another class within so many pixels (of its pyramid level) matches points of both without
  // penalty: half a pixel decides which of the two it gets. 0: it has the class of its pixel alone, as in the
  // paper.
  double class_rim_px = 0.0;
  // A point's class is what it was seen as most often; false: what it was seen as first.
  bool votes = true;
  // Points of inactive classes take no part in tracking, mapping, loops and relocalization.
  bool filter_inactive = true;
  std::vector<std::string> inactive_classes;
  // By this share of itself the distance of descriptors of different classes is raised; 0: not at all.
  double penalty = 0.5;
  // Descriptors of different classes never match, which the paper advises against.
  bool strict = false;

  // Classes that put points aside: none where they are not to be.
  ClassSet InactiveClasses() const;
  PointClassPolicy PointPolicy() const { return {votes, InactiveClasses()}; }

  void Read(ConfigReader& reader);
};

}  // namespace semmap
