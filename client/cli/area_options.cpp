#include "client/cli/area_options.h"

namespace semmap::client {
namespace {

void SetVector(const double* numbers, v1::Vector3* vector) {
  vector->set_x(numbers[0]);
  vector->set_y(numbers[1]);
  vector->set_z(numbers[2]);
}

}  // namespace

void AddAreaOptions(CLI::App& command, AreaOptions* options) {
  CLI::Option_group* area = command.add_option_group("Area", "Where to look: at most one of these");
  area->add_option("--box", options->box, "Only in a box: MINX MINY MINZ MAXX MAXY MAXZ, metres")
      ->expected(6);
  area->add_option("--sphere", options->sphere, "Only in a ball: X Y Z RADIUS, metres")->expected(4);
  area->add_option("--polygon", options->polygon,
                   "Only over a polygon on the ground: X Z of each of its 3 or more corners, metres")
      ->expected(6, 2000)
      ->check(CLI::Number);
  area->add_option("--nearest", options->nearest, "Only the nearest to a point: X Y Z COUNT")->expected(4);
  area->require_option(0, 1);
}

bool FillArea(const AreaOptions& options, v1::Area* area) {
  if (options.box.size() == 6) {
    SetVector(options.box.data(), area->mutable_box()->mutable_min());
    SetVector(options.box.data() + 3, area->mutable_box()->mutable_max());
    return true;
  }
  if (options.sphere.size() == 4) {
    SetVector(options.sphere.data(), area->mutable_sphere()->mutable_center());
    area->mutable_sphere()->set_radius_m(options.sphere[3]);
    return true;
  }
  if (!options.polygon.empty()) {
    // An odd number leaves a corner without its second coordinate, which the server refuses as no polygon.
    for (size_t i = 0; i + 1 < options.polygon.size(); i += 2) {
      v1::Vector3* corner = area->mutable_polygon()->add_corners();
      corner->set_x(options.polygon[i]);
      corner->set_z(options.polygon[i + 1]);
    }
    return true;
  }
  if (options.nearest.size() == 4) {
    SetVector(options.nearest.data(), area->mutable_nearest()->mutable_point());
    area->mutable_nearest()->set_count(static_cast<int32_t>(options.nearest[3]));
    return true;
  }
  return false;
}

}  // namespace semmap::client
