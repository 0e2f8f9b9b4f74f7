#pragma once

#include <vector>

#include "CLI/CLI.hpp"
#include "semmap/v1/query.pb.h"

namespace semmap::client {

// Where a query looks: at most one of these; everywhere without.
struct AreaOptions {
  std::vector<double> box;      // min x y z, max x y z
  std::vector<double> sphere;   // centre x y z, radius
  std::vector<double> polygon;  // corners on the ground, x z one after the other
  std::vector<double> nearest;  // point x y z, how many
};

void AddAreaOptions(CLI::App& command, AreaOptions* options);
// Sets `area` if one was given; true if so.
bool FillArea(const AreaOptions& options, v1::Area* area);

}  // namespace semmap::client
