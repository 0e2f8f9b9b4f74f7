#pragma once

#include <ceres/sized_cost_function.h>
#include <Eigen/Core>

#include "slam/geometry/se3.h"
#include "slam/optimize/pose_graph.h"

namespace semmap {

// A node of a pose graph, which Ceres moves in a chart around its initial pose: seven numbers (tau, omega,
// lambda), at first zero, of which six without scale, with
//   rotation = Exp(omega) * initial rotation, translation = initial translation + tau, scale = e^lambda *
//   initial.
class ChartedNode {
 public:
  explicit ChartedNode(const Sim3& initial) : initial_(initial) {}

  double* chart() { return chart_.data(); }
  Sim3 MapFromKeyFrame() const { return At(chart_.data(), true); }
  // The pose at another value of the chart, whose last number is read only with scale.
  Sim3 At(const double* chart, bool with_scale) const;

 private:
  Sim3 initial_;
  Eigen::Matrix<double, 7, 1> chart_ = Eigen::Matrix<double, 7, 1>::Zero();
};

// The residual of an edge (see OptimizePoseGraph): translation, rotation and, for kDof = 7, scale. Blocks:
// charts of `from` and `to`, of kDof numbers. Refers to edge and nodes.
template <int kDof>
class RelativePoseCost final : public ceres::SizedCostFunction<kDof, kDof, kDof> {
 public:
  RelativePoseCost(const PoseGraphEdge& edge, const ChartedNode& from, const ChartedNode& to)
      : edge_(edge), from_(from), to_(to) {}

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override;

 private:
  const PoseGraphEdge& edge_;
  const ChartedNode& from_;
  const ChartedNode& to_;
};

}  // namespace semmap
