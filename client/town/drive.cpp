#include "client/town/drive.h"

#include <cmath>

#include "absl/strings/str_cat.h"
#include "slam/common/status_macros.h"

namespace semmap::town {
namespace {
constexpr int kMaxVehicles = 200;
constexpr int kMaxPedestrians = 500;
// A jam must not make a drive endless.
constexpr double kSlowestMetresPerSecond = 0.5;
}  // namespace

absl::Status ValidateDrive(const DriveConfig& config) {
  if (config.traffic.vehicles < 0 || config.traffic.vehicles > kMaxVehicles) {
    return absl::InvalidArgumentError(absl::StrCat("vehicles: 0 to ", kMaxVehicles));
  }
  if (config.traffic.pedestrians < 0 || config.traffic.pedestrians > kMaxPedestrians) {
    return absl::InvalidArgumentError(absl::StrCat("pedestrians: 0 to ", kMaxPedestrians));
  }
  if (config.max_frames < 0) return absl::InvalidArgumentError("frames: at least 0");
  return absl::OkStatus();
}

absl::StatusOr<std::unique_ptr<TownDrive>> TownDrive::Create(const DriveConfig& config, const World* world) {
  SEMMAP_RETURN_IF_ERROR(ValidateDrive(config));
  SEMMAP_ASSIGN_OR_RETURN(const Weather weather, MakeWeather(config.weather));
  std::unique_ptr<TownDrive> drive(new TownDrive);
  drive->config_ = config;
  if (world == nullptr) {
    drive->own_world_ = std::make_unique<World>(NetworkConfig(), config.seed);
    world = drive->own_world_.get();
  } else if (world->seed() != config.seed) {
    return absl::InvalidArgumentError("the town was made from another seed");
  }
  drive->world_ = world;
  SEMMAP_ASSIGN_OR_RETURN(drive->route_, MakeRoute(world->network(), config.route));
  const uint64_t traffic_seed = config.traffic_seed != 0 ? config.traffic_seed : config.seed;
  drive->simulation_ =
      std::make_unique<Simulation>(world->network(), drive->route_, config.traffic, traffic_seed);
  RenderConfig render;
  render.camera = config.rig.Intrinsics();
  render.vignetting = static_cast<float>(config.rig.vignetting);
  SEMMAP_ASSIGN_OR_RETURN(drive->renderer_, Renderer::Create(*world, render, weather));
  drive->actors_ = std::make_unique<Actors>(*world, *drive->simulation_, drive->renderer_.get());
  drive->sensors_ = std::make_unique<VehicleSensors>(config.rig, traffic_seed);
  return drive;
}

void TownDrive::Skip() {
  if (next_ > 0) simulation_->Step(1 / config_.rig.frames_per_second);
  ++next_;
}

absl::StatusOr<bool> TownDrive::Next(DriveFrame* frame) {
  const double period = 1 / config_.rig.frames_per_second;
  if (config_.max_frames > 0 && next_ >= config_.max_frames) return false;
  if (next_ > 0) simulation_->Step(period);
  const EgoState ego = simulation_->Ego();
  if (config_.max_frames == 0 && (ego.travelled >= route_.path.length() ||
                                  simulation_->seconds() > route_.path.length() / kSlowestMetresPerSecond)) {
    return false;
  }
  const SE3 town_from_vehicle = TownFromVehicle(ego);
  frame->index = next_;
  frame->timestamp_ns = std::llround(1e9 * next_ * period);
  frame->town_from_camera = town_from_vehicle * config_.rig.VehicleFromCamera();
  const Eigen::Vector3d& eye = frame->town_from_camera.translation();
  const auto instances = actors_->Place(*simulation_, glm::vec3(glm::dvec3(eye.x(), eye.y(), eye.z())));
  const auto noise = static_cast<uint32_t>(2 * next_);
  SEMMAP_RETURN_IF_ERROR(renderer_->Render(frame->town_from_camera, instances, noise, &frame->left));
  if (config_.stereo) {
    const SE3 left_from_right(Eigen::Quaterniond::Identity(), Eigen::Vector3d(config_.rig.baseline_m, 0, 0));
    SEMMAP_RETURN_IF_ERROR(
        renderer_->Render(frame->town_from_camera * left_from_right, instances, noise + 1, &right_));
    right_.rgb.copyTo(frame->right_rgb);
  }
  frame->true_speed = ego.speed;
  frame->wheel_speed = sensors_->MeasureSpeed(ego.speed);
  frame->gnss = sensors_->MeasureGnss(simulation_->seconds(), town_from_vehicle.translation());
  ++next_;
  return true;
}

}  // namespace semmap::town
