#include "slam/optimize/pose_graph.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "slam/optimize/pose_graph_costs.h"
#include "tests/unit/optimize/synthetic_scene.h"

namespace semmap {
namespace {

Sim3 RandomSim3(double size, std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {std::exp(0.2 * size * normal(random)), SE3::Exp(RandomTangent(size, 0.5 * size, random))};
}

double PoseError(const Sim3& a, const Sim3& b) {
  return (a.rigid.translation() - b.rigid.translation()).norm() +
         (a.rigid.rotation() * b.rigid.rotation().conjugate()).vec().norm() +
         std::abs(std::log(a.scale / b.scale));
}

double MaxError(const PoseGraph& graph, const std::vector<Sim3>& truth) {
  double worst = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    worst = std::max(worst, PoseError(graph.nodes[i].map_from_keyframe, truth[i]));
  }
  return worst;
}

// A drive around a circle of 50 m, back to its start; nodes are placed by odometry, whose every step is wrong
// a little in the same direction, and the loop's end is known from one good edge.
struct Loop {
  PoseGraph graph;
  std::vector<Sim3> truth;
};

Loop MakeLoop(bool with_scale) {
  constexpr int kNodes = 120;
  Loop loop;
  loop.graph.with_scale = with_scale;
  for (int i = 0; i < kNodes; ++i) {
    const double angle = 2 * std::numbers::pi * i / kNodes;
    const Eigen::Quaterniond heading(Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY()));
    loop.truth.push_back({1, SE3(heading, 50 * Eigen::Vector3d(std::cos(angle), 0, std::sin(angle)))});
  }
  const Sim3 drift{with_scale ? 1.002 : 1.0,
                   SE3::Exp((Vector6d() << 0.01, 0.003, 0.01, 0.0002, 0.0005, -0.0003).finished())};
  loop.graph.nodes.push_back({loop.truth[0], true});
  for (int i = 1; i < kNodes; ++i) {
    const Sim3 step = loop.truth[i - 1].Inverse() * loop.truth[i] * drift;
    loop.graph.nodes.push_back({loop.graph.nodes.back().map_from_keyframe * step, false});
    PoseGraphEdge edge;
    edge.from = i - 1;
    edge.to = i;
    edge.from_from_to = step;
    loop.graph.edges.push_back(edge);
  }
  PoseGraphEdge closure;
  closure.from = kNodes - 1;
  closure.to = 0;
  closure.from_from_to = loop.truth.back().Inverse() * loop.truth[0];
  closure.translation_sigma = closure.rotation_sigma = closure.scale_sigma = 0.1;
  loop.graph.edges.push_back(closure);
  return loop;
}

template <int kDof>
void CheckJacobians() {
  using Jacobian = Eigen::Matrix<double, kDof, kDof, Eigen::RowMajor>;
  std::mt19937 random(1);
  for (int trial = 0; trial < 20; ++trial) {
    ChartedNode from(RandomSim3(3, random));
    ChartedNode to(RandomSim3(3, random));
    for (ChartedNode* node : {&from, &to}) {
      const Vector6d tangent = RandomTangent(0.5, 0.3, random);
      std::copy(tangent.data(), tangent.data() + 6, node->chart());
      if (kDof == 7) node->chart()[6] = 0.2;
    }
    PoseGraphEdge edge;
    edge.from_from_to = from.MapFromKeyFrame().Inverse() * to.MapFromKeyFrame() * RandomSim3(0.5, random);
    edge.translation_sigma = 0.5;
    edge.rotation_sigma = 0.1;
    edge.scale_sigma = 0.2;
    const RelativePoseCost<kDof> cost(edge, from, to);
    double* parameters[] = {from.chart(), to.chart()};
    Jacobian analytic[2];
    double* jacobians[] = {analytic[0].data(), analytic[1].data()};
    Eigen::Matrix<double, kDof, 1> residual;
    ASSERT_TRUE(cost.Evaluate(parameters, residual.data(), jacobians));
    for (int block = 0; block < 2; ++block) {
      for (int i = 0; i < kDof; ++i) {
        constexpr double kStep = 1e-6;
        Eigen::Matrix<double, kDof, 1> above;
        Eigen::Matrix<double, kDof, 1> below;
        const double value = parameters[block][i];
        parameters[block][i] = value + kStep;
        cost.Evaluate(parameters, above.data(), nullptr);
        parameters[block][i] = value - kStep;
        cost.Evaluate(parameters, below.data(), nullptr);
        parameters[block][i] = value;
        const Eigen::Matrix<double, kDof, 1> numeric = (above - below) / (2 * kStep);
        EXPECT_LT((analytic[block].col(i) - numeric).norm(), 1e-5 * analytic[block].norm())
            << block << " " << i;
      }
    }
  }
}

TEST(RelativePoseCost, JacobiansAreThoseOfTheResidual) {
  CheckJacobians<6>();
  CheckJacobians<7>();
}

TEST(RelativePoseCost, IsZeroWhenTheEdgeHolds) {
  std::mt19937 random(2);
  ChartedNode from(RandomSim3(3, random));
  ChartedNode to(RandomSim3(3, random));
  PoseGraphEdge edge;
  edge.from_from_to = from.MapFromKeyFrame().Inverse() * to.MapFromKeyFrame();
  const double* parameters[] = {from.chart(), to.chart()};
  Eigen::Matrix<double, 7, 1> residual;
  RelativePoseCost<7>(edge, from, to).Evaluate(parameters, residual.data(), nullptr);
  EXPECT_LT(residual.norm(), 1e-9);
}

class OptimizePoseGraphWith : public testing::TestWithParam<bool> {};

TEST_P(OptimizePoseGraphWith, ClosesALoop) {
  Loop loop = MakeLoop(GetParam());
  const double before = MaxError(loop.graph, loop.truth);
  const PoseGraphSummary summary = OptimizePoseGraph({}, &loop.graph);
  const double after = MaxError(loop.graph, loop.truth);
  EXPECT_GT(before, 3);
  EXPECT_LT(after, 0.2 * before);
  EXPECT_LT(summary.final_cost, 0.05 * summary.initial_cost);
  EXPECT_EQ(summary.edges_used, 120);
  EXPECT_EQ(loop.graph.nodes[0].map_from_keyframe.rigid.Matrix(), loop.truth[0].rigid.Matrix());
}

TEST_P(OptimizePoseGraphWith, RestoresAConsistentGraph) {
  Loop loop = MakeLoop(GetParam());
  for (PoseGraphEdge& edge : loop.graph.edges) {
    edge.from_from_to = loop.truth[edge.from].Inverse() * loop.truth[edge.to];
  }
  const PoseGraphSummary summary = OptimizePoseGraph({.max_iterations = 50}, &loop.graph);
  EXPECT_LT(MaxError(loop.graph, loop.truth), 1e-2);
  EXPECT_LT(summary.final_cost, 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Scale, OptimizePoseGraphWith, testing::Bool());

TEST(OptimizePoseGraph, KeepsScalesWithoutScale) {
  Loop loop = MakeLoop(false);
  for (PoseGraphNode& node : loop.graph.nodes) node.map_from_keyframe.scale = 2;
  OptimizePoseGraph({}, &loop.graph);
  for (const PoseGraphNode& node : loop.graph.nodes) EXPECT_EQ(node.map_from_keyframe.scale, 2);
}

TEST(OptimizePoseGraph, StiffEdgesGiveWayLess) {
  // Two measurements of one node's place that disagree.
  PoseGraph graph;
  graph.nodes.resize(2);
  graph.nodes[0].fixed = true;
  PoseGraphEdge near;
  near.from = 0;
  near.to = 1;
  near.from_from_to.rigid = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(1, 0, 0));
  near.translation_sigma = 1;
  PoseGraphEdge far = near;
  far.from_from_to.rigid = SE3(Eigen::Quaterniond::Identity(), Eigen::Vector3d(2, 0, 0));
  far.translation_sigma = 0.5;
  graph.edges = {near, far};
  OptimizePoseGraph({}, &graph);
  // Weighted mean with weights 1 and 4.
  EXPECT_NEAR(graph.nodes[1].map_from_keyframe.rigid.translation().x(), 1.8, 1e-3);
}

TEST(OptimizePoseGraph, HoldsTheFirstNodeWhenNoneIsFixed) {
  Loop loop = MakeLoop(true);
  loop.graph.nodes[0].fixed = false;
  OptimizePoseGraph({}, &loop.graph);
  EXPECT_LT(PoseError(loop.graph.nodes[0].map_from_keyframe, loop.truth[0]), 1e-9);
}

TEST(OptimizePoseGraph, LeavesOutWhatCannotBeUsed) {
  Loop loop = MakeLoop(true);
  PoseGraphEdge bad = loop.graph.edges[3];
  bad.to = 4000;
  loop.graph.edges.push_back(bad);
  bad = loop.graph.edges[3];
  bad.from_from_to.scale = 0;
  loop.graph.edges.push_back(bad);
  bad = loop.graph.edges[3];
  bad.rotation_sigma = std::numeric_limits<double>::quiet_NaN();
  loop.graph.edges.push_back(bad);
  bad = loop.graph.edges[3];
  bad.to = bad.from;
  loop.graph.edges.push_back(bad);
  EXPECT_EQ(OptimizePoseGraph({}, &loop.graph).edges_used, 120);
}

TEST(OptimizePoseGraph, StopsWhenToldTo) {
  Loop loop = MakeLoop(true);
  const PoseGraph before = loop.graph;
  const std::atomic<bool> stop = true;
  EXPECT_TRUE(OptimizePoseGraph({.stop = &stop}, &loop.graph).stopped);
  EXPECT_LT(PoseError(loop.graph.nodes[50].map_from_keyframe, before.nodes[50].map_from_keyframe), 1e-12);
}

TEST(OptimizePoseGraph, IsDeterministic) {
  Loop a = MakeLoop(true);
  Loop b = MakeLoop(true);
  OptimizePoseGraph({}, &a.graph);
  OptimizePoseGraph({}, &b.graph);
  for (size_t i = 0; i < a.graph.nodes.size(); ++i) {
    EXPECT_EQ(a.graph.nodes[i].map_from_keyframe.rigid.Matrix(),
              b.graph.nodes[i].map_from_keyframe.rigid.Matrix());
    EXPECT_EQ(a.graph.nodes[i].map_from_keyframe.scale, b.graph.nodes[i].map_from_keyframe.scale);
  }
}

TEST(OptimizePoseGraph, AcceptsAnEmptyGraph) {
  PoseGraph graph;
  EXPECT_EQ(OptimizePoseGraph({}, &graph).edges_used, 0);
}

}  // namespace
}  // namespace semmap
