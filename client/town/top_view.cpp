#include <algorithm>
#include <array>
#include <cstdio>
#include <numeric>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "client/town/commands.h"
#include "client/town/spawn_points.h"

namespace semmap::town {
namespace {

constexpr double kMargin = 45;  // metres around the outer junctions

class TopView {
 public:
  TopView(const World& world, double pixels_per_metre)
      : world_(world),
        scale_(pixels_per_metre),
        low_(world.network().Min() - kMargin),
        high_(world.network().Max() + kMargin) {
    image_.create(static_cast<int>((high_.y - low_.y) * scale_),
                  static_cast<int>((high_.x - low_.x) * scale_), CV_8UC3);
    image_.setTo(cv::Scalar(235, 235, 235));
  }

  // North is up, RGB.
  const cv::Mat& image() const { return image_; }

  void DrawMesh(const Mesh& mesh) {
    std::vector<size_t> triangles;
    for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
      const Vertex& vertex = mesh.vertices[mesh.indices[i]];
      if (vertex.normal[2] > 20 || vertex.class_id == static_cast<uint8_t>(ClassId::kVegetation))
        triangles.push_back(i);
    }
    std::stable_sort(triangles.begin(), triangles.end(), [&](size_t a, size_t b) {
      return mesh.vertices[mesh.indices[a]].position.z < mesh.vertices[mesh.indices[b]].position.z;
    });
    for (const size_t i : triangles) {
      std::vector<cv::Point> corners;
      for (size_t k = 0; k < 3; ++k)
        corners.push_back(At(glm::dvec2(mesh.vertices[mesh.indices[i + k]].position)));
      const Vertex& vertex = mesh.vertices[mesh.indices[i]];
      const auto& rgb = kClasses[vertex.class_id].rgb;
      const double light = 0.75 + 0.25 * vertex.tint[1] / 255.0;
      cv::fillConvexPoly(image_, corners, cv::Scalar(rgb[0], rgb[1], rgb[2]) * light);
    }
  }

  void DrawRoute(const Route& route, const cv::Scalar& colour, double shift) {
    std::vector<cv::Point> line;
    const Path path = route.path.Offset(shift);
    for (const glm::dvec2& point : path.points()) line.push_back(At(point));
    const int width = std::max(1, static_cast<int>(scale_ * 0.8));
    cv::polylines(image_, std::vector<std::vector<cv::Point>>{line}, false, colour, width, cv::LINE_AA);
    cv::circle(image_, line.front(), 3 * width, colour, cv::FILLED, cv::LINE_AA);
    cv::putText(image_, route.name, line.front() + cv::Point(4 * width, 0), cv::FONT_HERSHEY_SIMPLEX,
                0.25 * scale_, colour, 2, cv::LINE_AA);
  }

  void DrawSpawnPoints() {
    for (const SpawnPoint& point : SpawnPoints(world_.network(), 154)) {
      cv::circle(image_, At(point.position), std::max(2, static_cast<int>(scale_)), cv::Scalar(255, 140, 0),
                 cv::FILLED, cv::LINE_AA);
    }
  }

 private:
  cv::Point At(const glm::dvec2& point) const {
    return {static_cast<int>((point.x - low_.x) * scale_), static_cast<int>((high_.y - point.y) * scale_)};
  }

  const World& world_;
  double scale_;
  glm::dvec2 low_;
  glm::dvec2 high_;
  cv::Mat image_;
};

}  // namespace

int RunTownMap(const MapCommand& command) {
  const World world(NetworkConfig(), command.seed);
  TopView view(world, command.pixels_per_metre);
  view.DrawMesh(world.mesh().solid());
  view.DrawMesh(world.mesh().cut());
  view.DrawSpawnPoints();
  static const std::array<cv::Scalar, 5> kColours = {cv::Scalar(220, 30, 30), cv::Scalar(30, 90, 230),
                                                     cv::Scalar(0, 160, 60), cv::Scalar(230, 0, 200),
                                                     cv::Scalar(0, 190, 210)};
  absl::Status status;
  for (size_t i = 0; i < RouteNames().size(); ++i) {
    const auto route = MakeRoute(world.network(), RouteNames()[i]);
    if (!route.ok()) {
      status = route.status();
      break;
    }
    view.DrawRoute(*route, kColours[i % kColours.size()], 0.7 * static_cast<double>(i) - 1.4);
    std::printf("route %s: %.1f m\n", route->name.c_str(), route->path.length());
  }
  if (status.ok()) status = WritePng(command.output, view.image());
  if (status.ok()) return 0;
  std::fprintf(stderr, "town: %s\n", status.ToString().c_str());
  return 1;
}

}  // namespace semmap::town
