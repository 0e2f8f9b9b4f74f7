#pragma once

#include <atomic>
#include <vector>

#include "slam/geometry/se3.h"

namespace semmap {

struct PoseGraphNode {
  Sim3 map_from_keyframe;
  bool fixed = false;
};

// A measured relative pose: where keyframe `to` is as seen from keyframe `from`.
struct PoseGraphEdge {
  int from = 0;  // indices into PoseGraph::nodes
  int to = 0;
  Sim3 from_from_to;
  // Standard deviations of the measurement, in units of `from`'s frame, radians, and of the scale's
  // logarithm.
  double translation_sigma = 1;
  double rotation_sigma = 1;
  double scale_sigma = 1;
};

struct PoseGraph {
  // True: seven degrees of freedom, for monocular maps, whose scale drifts. False: six; scales stay as they
  // are.
  bool with_scale = false;
  std::vector<PoseGraphNode> nodes;
  std::vector<PoseGraphEdge> edges;
};

struct PoseGraphOptions {
  int max_iterations = 20;
  int threads = 1;
  // Optional: becoming true ends the solve after the current iteration.
  const std::atomic<bool>* stop = nullptr;
};

struct PoseGraphSummary {
  double initial_cost = 0;
  double final_cost = 0;
  int iterations = 0;
  int edges_used = 0;
  bool stopped = false;
};

// Moves the free nodes to where they agree best with the measured relative poses (Strasdat, Montiel and
// Davison, "Scale drift-aware large scale monocular SLAM", RSS 2010), by Ceres with analytic Jacobians. The
// residual of an edge is the difference of the translations in `from`'s frame, the rotation vector of the
// rotation error and the logarithm of the scale error, each over its sigma. Edges between two fixed nodes, to
// nodes that do not exist, or with values that are not finite or scales that are not positive are left out.
// Without a fixed node the first one is held. Nodes are unchanged when the solve fails. Deterministic with
// threads = 1.
PoseGraphSummary OptimizePoseGraph(const PoseGraphOptions& options, PoseGraph* graph);

}  // namespace semmap
