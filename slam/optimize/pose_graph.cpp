#include "slam/optimize/pose_graph.h"

#include <algorithm>
#include <cmath>
#include <deque>

#include <ceres/problem.h>
#include <ceres/solver.h>

#include "slam/optimize/pose_graph_costs.h"
#include "slam/optimize/stop_callback.h"

namespace semmap {
namespace {

constexpr double kGraphTolerance = 1e-6;

bool IsPositive(double value) { return std::isfinite(value) && value > 0; }

bool IsValid(const Sim3& pose) { return IsPositive(pose.scale) && pose.rigid.IsFinite(); }

bool IsUsable(const PoseGraph& graph, const PoseGraphEdge& edge) {
  const int size = static_cast<int>(graph.nodes.size());
  if (edge.from < 0 || edge.from >= size || edge.to < 0 || edge.to >= size || edge.from == edge.to)
    return false;
  const PoseGraphNode& from = graph.nodes[edge.from];
  const PoseGraphNode& to = graph.nodes[edge.to];
  return !(from.fixed && to.fixed) && IsValid(from.map_from_keyframe) && IsValid(to.map_from_keyframe) &&
         IsValid(edge.from_from_to) && IsPositive(edge.translation_sigma) &&
         IsPositive(edge.rotation_sigma) && IsPositive(edge.scale_sigma);
}

ceres::Problem::Options ProblemOptions() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  return options;
}

template <int kDof>
class PoseGraphSolver {
 public:
  explicit PoseGraphSolver(PoseGraph* graph) : graph_(graph), problem_(ProblemOptions()) {
    nodes_.reserve(graph->nodes.size());
    for (const PoseGraphNode& node : graph->nodes) nodes_.emplace_back(node.map_from_keyframe);
    for (const PoseGraphEdge& edge : graph->edges) {
      if (!IsUsable(*graph, edge)) continue;
      costs_.emplace_back(edge, nodes_[edge.from], nodes_[edge.to]);
      problem_.AddResidualBlock(&costs_.back(), nullptr, nodes_[edge.from].chart(), nodes_[edge.to].chart());
    }
    HoldFixedNodes();
  }

  PoseGraphSummary Run(const PoseGraphOptions& options) {
    StopCallback stop(options.stop);
    PoseGraphSummary summary;
    summary.edges_used = static_cast<int>(costs_.size());
    summary.stopped = stop.Requested();
    if (costs_.empty() || summary.stopped) return summary;
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    solver.max_num_iterations = options.max_iterations;
    solver.function_tolerance = kGraphTolerance;
    solver.num_threads = std::max(1, options.threads);
    solver.logging_type = ceres::SILENT;
    solver.callbacks.push_back(&stop);
    ceres::Solver::Summary result;
    ceres::Solve(solver, &problem_, &result);
    summary.initial_cost = result.initial_cost;
    summary.final_cost = result.final_cost;
    summary.iterations = result.num_successful_steps + result.num_unsuccessful_steps;
    summary.stopped = stop.Requested();
    if (result.IsSolutionUsable()) StoreNodes();
    return summary;
  }

 private:
  void HoldFixedNodes() {
    bool any_fixed = false;
    for (size_t i = 0; i < nodes_.size(); ++i) {
      if (!graph_->nodes[i].fixed) continue;
      any_fixed = true;
      if (problem_.HasParameterBlock(nodes_[i].chart()))
        problem_.SetParameterBlockConstant(nodes_[i].chart());
    }
    if (any_fixed) return;
    const auto first = std::find_if(nodes_.begin(), nodes_.end(), [this](ChartedNode& node) {
      return problem_.HasParameterBlock(node.chart());
    });
    if (first != nodes_.end()) problem_.SetParameterBlockConstant(first->chart());
  }

  void StoreNodes() {
    for (size_t i = 0; i < nodes_.size(); ++i) {
      PoseGraphNode& node = graph_->nodes[i];
      if (!node.fixed) node.map_from_keyframe = nodes_[i].MapFromKeyFrame();
    }
  }

  PoseGraph* graph_;
  // Neither may reallocate: Ceres and the costs hold addresses. One array, since Ceres orders blocks by
  // address.
  std::vector<ChartedNode> nodes_;
  std::deque<RelativePoseCost<kDof>> costs_;
  ceres::Problem problem_;
};

}  // namespace

PoseGraphSummary OptimizePoseGraph(const PoseGraphOptions& options, PoseGraph* graph) {
  return graph->with_scale ? PoseGraphSolver<7>(graph).Run(options) : PoseGraphSolver<6>(graph).Run(options);
}

}  // namespace semmap
