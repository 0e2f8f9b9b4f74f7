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
  CLI::Option* box =
      command.add_option("--box", options->box, "Only in a box: MINX MINY MINZ MAXX MAXY MAXZ, metres");
  box->expected(6);
  command.add_option("--sphere", options->sphere, "Only in a ball: X Y Z RADIUS, metres")
      ->expected(4)
      ->excludes(box);
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
  return false;
}

}  // namespace semmap::client
