#pragma once

#include <vector>

#include "slam/features/frame_features.h"
#include "slam/map/local_map_view.h"
#include "slam/map/map.h"
#include "slam/pipeline/association.h"
#include "slam/place/place_description.h"

namespace semmap {

// Pairs of a keyframe's keypoints that see an active point of the map (first) with an image's keypoints
// (second), by descriptors alone: clearly nearer than the second best, one to one, and turned alike.

// Compares within the nodes of the vocabulary only: fast, for many candidates (Galvez-Lopez and Tardos 2012,
// section IV-C).
std::vector<KeypointPair> MatchWithinNodes(const AssociationRule& rule, const Map& map,
                                           const KeyFrame& keyframe, const DirectIndex& keyframe_nodes,
                                           const FrameFeatures& image, const DirectIndex& image_nodes);
// The same, of the view's points.
std::vector<KeypointPair> MatchWithinNodes(const AssociationRule& rule, const LocalMapView& view,
                                           const ViewKeyFrame& keyframe, const DirectIndex& keyframe_nodes,
                                           const FrameFeatures& image, const DirectIndex& image_nodes);

// Compares with all: slower, misses fewer. The second looks at the view's points only.
std::vector<KeypointPair> MatchExhaustively(const AssociationRule& rule, const Map& map,
                                            const KeyFrame& keyframe, const FrameFeatures& image);
std::vector<KeypointPair> MatchExhaustively(const AssociationRule& rule, const LocalMapView& view,
                                            const ViewKeyFrame& keyframe, const FrameFeatures& image);

}  // namespace semmap
