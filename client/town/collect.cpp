#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>
#include <system_error>
#include <vector>

#include <glm/geometric.hpp>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_format.h"
#include "client/town/commands.h"
#include "client/town/spawn_points.h"
#include "slam/common/status_macros.h"

// The paper's section 2: at each spawn point the vehicle is set down, turned on the spot, and at each heading
// an image and its class mask are kept.
namespace semmap::town {
namespace {

constexpr uint64_t kSplitPurpose = 141;
constexpr double kTrainShare = 0.8;
constexpr double kClearAround = 6.0;  // no other vehicle where the collecting one stands
constexpr double kSecondsBetweenPoints = 2.0;
constexpr double kStep = 0.05;

struct ClassCount {
  std::array<int64_t, kClassCount> pixels{};
  std::array<int64_t, kClassCount> images{};
  int64_t total = 0;

  void Add(const cv::Mat& mask) {
    std::array<int64_t, 256> histogram{};
    for (int y = 0; y < mask.rows; ++y) {
      const auto* row = mask.ptr<uint8_t>(y);
      for (int x = 0; x < mask.cols; ++x) ++histogram[row[x]];
    }
    for (size_t i = 0; i < kClassCount; ++i) {
      pixels[i] += histogram[i];
      images[i] += histogram[i] > 0 ? 1 : 0;
    }
    total += static_cast<int64_t>(mask.total());
  }
};

class Collector {
 public:
  explicit Collector(const CollectCommand& command) : command_(command) {}

  absl::Status Run() {
    SEMMAP_RETURN_IF_ERROR(Prepare());
    std::vector<std::string> weathers = {command_.weather};
    if (command_.weather == "all") weathers = WeatherNames();
    const std::vector<SpawnPoint> points = SpawnPoints(world_->network(), command_.points);
    for (size_t turn = 0; turn < weathers.size(); ++turn) {
      SEMMAP_RETURN_IF_ERROR(MakeRenderer(weathers[turn]));
      for (size_t i = turn; i < points.size(); i += weathers.size())
        SEMMAP_RETURN_IF_ERROR(CollectAt(i, points[i]));
    }
    SEMMAP_RETURN_IF_ERROR(WriteSplit());
    return Report();
  }

 private:
  absl::Status Prepare() {
    std::error_code error;
    const std::filesystem::path folder(command_.output);
    if (std::filesystem::exists(folder, error) && !std::filesystem::is_empty(folder, error)) {
      return absl::AlreadyExistsError(command_.output + " exists and is not empty");
    }
    for (const char* name : {"images", "masks"}) {
      std::filesystem::create_directories(folder / name, error);
      if (error)
        return absl::InternalError(absl::StrCat("cannot make ", command_.output, ": ", error.message()));
    }
    if (!command_.rig_file.empty()) {
      SEMMAP_ASSIGN_OR_RETURN(rig_, RigConfig::FromFile(command_.rig_file));
    }
    world_ = std::make_unique<World>(NetworkConfig(), command_.seed);
    return absl::OkStatus();
  }

  absl::Status MakeRenderer(const std::string& weather_name) {
    SEMMAP_ASSIGN_OR_RETURN(const Weather weather, MakeWeather(weather_name));
    // Traffic is spread over all streets, as if every lane were the route.
    Route everywhere;
    for (const Lane& lane : world_->network().lanes()) everywhere.lanes.push_back(lane.id);
    SEMMAP_ASSIGN_OR_RETURN(Route background, MakeRoute(world_->network(), "1"));
    background.lanes.resize(1);
    background.turns.clear();
    simulation_ =
        std::make_unique<Simulation>(world_->network(), background, everywhere,
                                     TrafficConfig{command_.vehicles, command_.pedestrians}, command_.seed);
    RenderConfig render;
    render.camera = rig_.Intrinsics();
    render.vignetting = static_cast<float>(rig_.vignetting);
    SEMMAP_ASSIGN_OR_RETURN(renderer_, Renderer::Create(*world_, render, weather));
    actors_ = std::make_unique<Actors>(*world_, *simulation_, renderer_.get());
    return absl::OkStatus();
  }

  absl::Status CollectAt(size_t point_index, const SpawnPoint& point) {
    for (double t = 0; t < kSecondsBetweenPoints; t += kStep) simulation_->Step(kStep);
    const glm::vec3 eye(glm::vec2(point.position), 1.5F);
    std::vector<Instance> instances = actors_->Place(*simulation_, eye);
    std::erase_if(instances, [&](const Instance& instance) {
      return glm::distance(glm::vec2(instance.town_from_model[3]), glm::vec2(eye)) < kClearAround &&
             instance.town_from_model[3].z < 0.5F;
    });
    for (int view = 0; view < command_.views; ++view) {
      EgoState ego;
      ego.position = glm::dvec3(point.position, 0);
      ego.heading = point.heading + 2 * std::numbers::pi * (view + 1) / command_.views;
      const int index = static_cast<int>(point_index) * command_.views + view;
      View seen;
      SEMMAP_RETURN_IF_ERROR(renderer_->Render(TownFromVehicle(ego) * rig_.VehicleFromCamera(), instances,
                                               static_cast<uint32_t>(index), &seen));
      const std::string name = absl::StrFormat("%06d.png", index);
      SEMMAP_RETURN_IF_ERROR(WritePng(absl::StrCat(command_.output, "/images/", name), seen.rgb));
      SEMMAP_RETURN_IF_ERROR(WritePng(absl::StrCat(command_.output, "/masks/", name), seen.mask));
      count_.Add(seen.mask);
      ++pairs_;
    }
    return absl::OkStatus();
  }

  // A random four fifths of the images for training, as the paper does. Images of one point overlap; who
  // wants the two sets to share no place splits by index / views.
  absl::Status WriteSplit() const {
    std::vector<int> order(static_cast<size_t>(pairs_));
    for (int i = 0; i < pairs_; ++i) order[static_cast<size_t>(i)] = i;
    Random random(command_.seed, kSplitPurpose);
    for (size_t i = order.size(); i > 1; --i)
      std::swap(order[i - 1], order[static_cast<size_t>(random.Below(static_cast<int>(i)))]);
    const auto train = static_cast<size_t>(std::llround(kTrainShare * pairs_));
    for (const bool training : {true, false}) {
      const std::string path = absl::StrCat(command_.output, training ? "/train.txt" : "/val.txt");
      std::FILE* file = std::fopen(path.c_str(), "w");
      if (file == nullptr) return absl::InternalError("cannot write " + path);
      std::vector<int> part(order.begin() + static_cast<ptrdiff_t>(training ? 0 : train),
                            training ? order.begin() + static_cast<ptrdiff_t>(train) : order.end());
      std::sort(part.begin(), part.end());
      for (const int index : part) std::fprintf(file, "%06d\n", index);
      std::fclose(file);
    }
    return absl::OkStatus();
  }

  absl::Status Report() const {
    std::string table = "id,class,pixel_share,images\n";
    for (size_t i = 0; i < kClassCount; ++i) {
      const double share =
          static_cast<double>(count_.pixels[i]) / static_cast<double>(std::max<int64_t>(1, count_.total));
      absl::StrAppend(&table, absl::StrFormat("%d,%s,%.6f,%d\n", static_cast<int>(i), kClasses[i].name, share,
                                              count_.images[i]));
    }
    const std::string path = command_.output + "/classes.csv";
    std::FILE* file = std::fopen(path.c_str(), "w");
    if (file == nullptr) return absl::InternalError("cannot write " + path);
    std::fputs(table.c_str(), file);
    std::fclose(file);
    std::printf("%d pairs of image and mask, %d points, %s\n%s", pairs_, command_.points,
                renderer_->device().c_str(), table.c_str());
    return absl::OkStatus();
  }

  CollectCommand command_;
  RigConfig rig_;
  std::unique_ptr<World> world_;
  std::unique_ptr<Simulation> simulation_;
  std::unique_ptr<Renderer> renderer_;
  std::unique_ptr<Actors> actors_;
  ClassCount count_;
  int pairs_ = 0;
};

}  // namespace

int RunTownCollect(const CollectCommand& command) {
  const absl::Status status = Collector(command).Run();
  if (status.ok()) return 0;
  std::fprintf(stderr, "town: %s\n", status.ToString().c_str());
  return 1;
}

}  // namespace semmap::town
