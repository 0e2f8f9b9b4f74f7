#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "client/town/actors.h"
#include "client/town/renderer.h"
#include "client/town/rig.h"
#include "client/town/sensors.h"
#include "client/town/simulation.h"
#include "client/town/weather.h"
#include "client/town/world.h"

namespace semmap::town {

struct DriveConfig {
  uint64_t seed = 1;          // of the town: its streets and houses
  uint64_t traffic_seed = 0;  // of traffic and sensor errors; 0: the town's
  std::string route = "1";
  TrafficConfig traffic;
  std::string weather = "noon";
  RigConfig rig;
  bool stereo = false;
  int max_frames = 0;  // 0: to the end of the route
};

// Everything that the vehicle sensed at one instant, and the truth.
struct DriveFrame {
  int index = 0;
  int64_t timestamp_ns = 0;
  View left;
  cv::Mat right_rgb;            // CV_8UC3; empty without stereo
  SE3 town_from_camera;         // truth, of the left camera
  double true_speed = 0;        // m/s
  double wheel_speed = 0;       // m/s, with errors
  std::optional<GnssFix> gnss;  // with errors; not in every frame
};

// A simulated vehicle's drive along one route, frame by frame: the same configuration gives the same frames.
// Used by one thread at a time.
class TownDrive {
 public:
  // Makes the town too, unless one of the same seed is given, which must outlive the drive. NOT_FOUND for
  // unknown routes, INVALID_ARGUMENT for what is out of bounds, UNAVAILABLE without off-screen OpenGL.
  static absl::StatusOr<std::unique_ptr<TownDrive>> Create(const DriveConfig& config,
                                                           const World* world = nullptr);

  // False when the route's end, or the number of frames asked for, is reached.
  absl::StatusOr<bool> Next(DriveFrame* frame);
  // Passes over one frame: time goes on, nothing is drawn or measured.
  void Skip();

  const DriveConfig& config() const { return config_; }
  const Route& route() const { return route_; }
  const Simulation& simulation() const { return *simulation_; }
  const std::string& device() const { return renderer_->device(); }
  // The number of frames until now.
  int frames() const { return next_; }

 private:
  TownDrive() = default;

  DriveConfig config_;
  std::unique_ptr<World> own_world_;
  const World* world_ = nullptr;
  Route route_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<Actors> actors_;
  std::unique_ptr<VehicleSensors> sensors_;
  View right_;
  int next_ = 0;
};

absl::Status ValidateDrive(const DriveConfig& config);

}  // namespace semmap::town
