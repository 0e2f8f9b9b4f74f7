#include "slam/optimize/bundle_adjustment.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <memory>
#include <numeric>

#include <ceres/evaluation_callback.h>
#include <ceres/loss_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include "slam/optimize/bundle_costs.h"
#include "slam/optimize/stop_callback.h"

namespace semmap {
namespace {

// Up to this many free cameras the reduced camera matrix is small and, in a covisible window, nearly full. Measured
// for one linear solve along a straight drive, where sparsity helps most: 20 cameras 1.8 ms dense and 3.5 sparse,
// 100 the same, 200 twice as long dense.
constexpr int kMaxDenseCameras = 60;
// The cost is a sum of squares over sigma^2: a relative change of this is far below what the noise moves.
constexpr double kFunctionTolerance = 1e-4;
constexpr double kParameterTolerance = 1e-7;

// Computes each camera's matrices once for an evaluation instead of once for an observation.
class CameraUpdater final : public ceres::EvaluationCallback {
 public:
  explicit CameraUpdater(std::vector<ChartedCamera>* cameras) : cameras_(cameras) {}

  void PrepareForEvaluation(bool /*evaluate_jacobians*/, bool new_evaluation_point) override {
    if (new_evaluation_point) UpdateAll();
  }
  void UpdateAll() {
    for (ChartedCamera& camera : *cameras_) camera.Update();
  }

 private:
  std::vector<ChartedCamera>* cameras_;
};

bool IsUsable(const BundleProblem& problem, const BundleObservation& observation) {
  const PixelObservation& pixel = observation.pixel;
  return observation.camera >= 0 && observation.camera < static_cast<int>(problem.cameras.size()) &&
         observation.point >= 0 && observation.point < static_cast<int>(problem.points.size()) &&
         std::isfinite(pixel.u) && std::isfinite(pixel.v) && std::isfinite(pixel.u_right) &&
         std::isfinite(pixel.inverse_sigma2) && pixel.inverse_sigma2 > 0 &&
         problem.points[observation.point].allFinite() &&
         problem.cameras[observation.camera].camera_from_map.IsFinite();
}

// The observations that can be used, point by point; marks the others. Ceres walks through the residuals of a
// point together, so that allocating them in this order keeps them together in memory.
std::vector<BundleObservation*> UsableByPoint(BundleProblem* problem) {
  std::vector<size_t> end_of_point(problem->points.size() + 1);
  for (BundleObservation& observation : problem->observations) {
    observation.outlier = !IsUsable(*problem, observation);
    if (!observation.outlier) ++end_of_point[observation.point + 1];
  }
  std::partial_sum(end_of_point.begin(), end_of_point.end(), end_of_point.begin());
  std::vector<BundleObservation*> sorted(end_of_point.back());
  for (BundleObservation& observation : problem->observations) {
    if (!observation.outlier) sorted[end_of_point[observation.point]++] = &observation;
  }
  return sorted;
}

// One bundle adjustment: translates to Ceres once and solves it in rounds. An outlier stays in Ceres' problem
// with a residual of zero, which is cheaper than a second problem.
class BundleSolver {
 public:
  BundleSolver(const BundleOptions& options, BundleProblem* problem);

  BundleSummary Run();

 private:
  void AddObservation(const BundleObservation& observation);
  template <int kRows>
  void AddResidual(const BundleObservation& observation, ceres::LossFunction* loss);
  void ConfigureSolver();
  bool SolveRound(int max_iterations, BundleSummary* summary);
  int MarkOutliers();
  double Chi2Of(const BundleObservation& observation) const;
  double RobustCost() const;

  template <int kRows>
  struct Costs {
    // Deques: elements neither move nor cost an allocation each.
    std::deque<MovingCameraCost<kRows>> moving;
    std::deque<FixedCameraCost<kRows>> fixed;
  };
  template <int kRows>
  Costs<kRows>& CostsOf() {
    if constexpr (kRows == 2) {
      return mono_costs_;
    } else {
      return stereo_costs_;
    }
  }

  BundleOptions options_;
  BundleProblem* problem_;
  std::vector<BundleObservation*> used_;
  // In one array that never grows: Ceres holds the charts' addresses, and orders parameter blocks by them, so
  // that scattered ones would give another rounding in each run.
  std::vector<ChartedCamera> cameras_;
  CameraUpdater updater_{&cameras_};
  StopCallback stop_;
  Costs<2> mono_costs_;
  Costs<3> stereo_costs_;
  ceres::HuberLoss mono_loss_{std::sqrt(kChi2Mono)};
  ceres::HuberLoss stereo_loss_{std::sqrt(kChi2Stereo)};
  ceres::Problem ceres_problem_;
  ceres::Solver::Options solver_options_;
};

ceres::Problem::Options ProblemOptions(CameraUpdater* updater) {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.disable_all_safety_checks = true;
  options.evaluation_callback = updater;
  return options;
}

BundleSolver::BundleSolver(const BundleOptions& options, BundleProblem* problem)
    : options_(options), problem_(problem), stop_(options.stop), ceres_problem_(ProblemOptions(&updater_)) {
  cameras_.reserve(problem_->cameras.size());
  for (const BundleCamera& camera : problem_->cameras) cameras_.emplace_back(camera.camera_from_map);
  used_ = UsableByPoint(problem_);
  for (const BundleObservation* observation : used_) AddObservation(*observation);
  ConfigureSolver();
}

void BundleSolver::AddObservation(const BundleObservation& observation) {
  if (observation.pixel.IsStereo()) {
    AddResidual<3>(observation, &stereo_loss_);
  } else {
    AddResidual<2>(observation, &mono_loss_);
  }
}

template <int kRows>
void BundleSolver::AddResidual(const BundleObservation& observation, ceres::LossFunction* loss) {
  Costs<kRows>& costs = CostsOf<kRows>();
  ChartedCamera& camera = cameras_[observation.camera];
  double* point = problem_->points[observation.point].data();
  if (problem_->cameras[observation.camera].fixed) {
    costs.fixed.emplace_back(problem_->model, camera, observation);
    ceres_problem_.AddResidualBlock(&costs.fixed.back(), loss, point);
  } else {
    costs.moving.emplace_back(problem_->model, camera, observation);
    ceres_problem_.AddResidualBlock(&costs.moving.back(), loss, point, camera.chart());
  }
}

void BundleSolver::ConfigureSolver() {
  std::vector<char> has_camera(cameras_.size());
  std::vector<char> has_point(problem_->points.size());
  for (const BundleObservation* observation : used_) {
    has_point[observation->point] = 1;
    has_camera[observation->camera] = problem_->cameras[observation->camera].fixed ? 0 : 1;
  }
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (size_t i = 0; i < has_point.size(); ++i) {
    if (has_point[i]) ordering->AddElementToGroup(problem_->points[i].data(), 0);
  }
  for (size_t i = 0; i < has_camera.size(); ++i) {
    if (has_camera[i]) ordering->AddElementToGroup(cameras_[i].chart(), 1);
  }
  const auto free_cameras = std::count(has_camera.begin(), has_camera.end(), 1);
  solver_options_.linear_solver_ordering = std::move(ordering);
  solver_options_.linear_solver_type =
      free_cameras <= kMaxDenseCameras ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
  solver_options_.function_tolerance = kFunctionTolerance;
  solver_options_.parameter_tolerance = kParameterTolerance;
  solver_options_.num_threads = std::max(1, options_.threads);
  solver_options_.logging_type = ceres::SILENT;
  solver_options_.callbacks.push_back(&stop_);
}

// False when Ceres failed; points and charts are then as they were before.
bool BundleSolver::SolveRound(int max_iterations, BundleSummary* summary) {
  const std::vector<Eigen::Vector3d> points_before = problem_->points;
  const std::vector<ChartedCamera> cameras_before = cameras_;
  solver_options_.max_num_iterations = max_iterations;
  ceres::Solver::Summary ceres_summary;
  ceres::Solve(solver_options_, &ceres_problem_, &ceres_summary);
  summary->iterations += ceres_summary.num_successful_steps + ceres_summary.num_unsuccessful_steps;
  if (!ceres_summary.IsSolutionUsable()) {
    // Assigned element by element: Ceres and the cost functions hold the addresses.
    std::copy(points_before.begin(), points_before.end(), problem_->points.begin());
    std::copy(cameras_before.begin(), cameras_before.end(), cameras_.begin());
  }
  updater_.UpdateAll();
  return ceres_summary.IsSolutionUsable();
}

int BundleSolver::MarkOutliers() {
  for (BundleObservation* observation : used_) {
    observation->outlier = !(Chi2Of(*observation) <= Chi2Bound(observation->pixel));
  }
  return static_cast<int>(std::count_if(problem_->observations.begin(), problem_->observations.end(),
                                        [](const BundleObservation& o) { return o.outlier; }));
}

double BundleSolver::Chi2Of(const BundleObservation& observation) const {
  return Chi2(problem_->model, cameras_[observation.camera], problem_->points[observation.point],
              observation.pixel);
}

double BundleSolver::RobustCost() const {
  double cost = 0;
  for (const BundleObservation* observation : used_) {
    const double chi2 = std::min(Chi2Of(*observation), kChi2Behind);
    const double bound = Chi2Bound(observation->pixel);
    cost += chi2 <= bound ? chi2 : 2 * std::sqrt(bound * chi2) - bound;
  }
  return 0.5 * cost;
}

BundleSummary BundleSolver::Run() {
  BundleSummary summary;
  summary.initial_cost = RobustCost();
  if (!used_.empty() && !stop_.Requested()) {
    const bool usable = SolveRound(options_.first_iterations, &summary);
    if (usable && !stop_.Requested() && MarkOutliers() > 0) SolveRound(options_.second_iterations, &summary);
  }
  summary.stopped = stop_.Requested();
  summary.final_cost = RobustCost();
  summary.outliers = MarkOutliers();
  for (size_t i = 0; i < cameras_.size(); ++i) {
    BundleCamera& camera = problem_->cameras[i];
    if (!camera.fixed) camera.camera_from_map = cameras_[i].CameraFromMap();
  }
  return summary;
}

}  // namespace

BundleSummary AdjustBundle(const BundleOptions& options, BundleProblem* problem) {
  return BundleSolver(options, problem).Run();
}

}  // namespace semmap
