#pragma once

#include <unordered_map>
#include <vector>

#include "slam/map/map.h"
#include "slam/optimize/pose_graph.h"
#include "slam/pipeline/loop_verifier.h"

namespace semmap {

// The pose graph of a map (Mur-Artal et al. 2015, section III-D): its keyframes, tied by the spanning tree,
// strongly covisible pairs, earlier loops, and what is added. Keyframes without a parent are held. A value.
class EssentialGraph {
 public:
  // Pairs that share `min_shared` points are tied. With scale: seven degrees of freedom.
  EssentialGraph(int min_shared, bool with_scale, const Map& map);

  // Relative poses of the drive have precision 1; a smaller one ties more firmly.
  void AddLoop(const Loop& loop, double precision);
  PoseGraphSummary Optimize(const PoseGraphOptions& options) { return OptimizePoseGraph(options, &graph_); }
  // Keyframes go to where their nodes are, points keep their place in the frame of their reference keyframe,
  // whose unit may have changed.
  void WriteBack(Map* map) const;

  const Sim3& MapFromKeyFrame(KeyFrameId id) const { return graph_.nodes[index_.at(id)].map_from_keyframe; }

 private:
  void AddEdgesOf(const KeyFrame& keyframe, int min_shared);
  void AddEdge(KeyFrameId from, KeyFrameId to);
  double TypicalDistance() const;
  void Weigh(double precision, PoseGraphEdge* edge) const;
  void MovePoints(Map* map) const;
  void MoveKeyFrames(Map* map) const;

  PoseGraph graph_;
  std::vector<KeyFrameId> ids_;
  std::unordered_map<KeyFrameId, int, IdHash> index_;
  double typical_distance_ = 1;
};

}  // namespace semmap
