#pragma once

#include "slam/optimize/pose_graph.h"
#include "slam/pipeline/loop_verifier.h"

namespace semmap {

struct LoopCorrection {
  PoseGraphSummary pose_graph;
  // How far the current keyframe moved.
  double shift = 0;
  double scale = 1;  // of its surroundings
  int fused_points = 0;
};

// Closes a loop in the map: distributes the error over all keyframes by a pose graph over the essential graph
// (spanning tree, strongly covisible pairs, earlier loops, this one), lets the points follow their reference
// keyframes, and joins what was mapped twice (Mur-Artal et al. 2015, section VII). One camera: seven degrees
// of freedom, scale drifts too; with depth six. The map's frame stays where it is.
LoopCorrection CloseLoop(const LoopConfig& config, const MappingCamera& camera, const Loop& loop, Map* map);

// Joins what both ends of a loop show, which lie together already but for some pixels: first what both images
// were seen to show, then what both groups of keyframes do. Returns how many points were joined or gained an
// observation.
int FuseLoopEnds(const MappingCamera& camera, const Loop& loop, Map* map);

}  // namespace semmap
