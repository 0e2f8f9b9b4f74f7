#include "client/town/world.h"

#include "client/town/house_builder.h"
#include "client/town/landscape.h"
#include "client/town/lots.h"
#include "client/town/street_builder.h"

namespace semmap::town {

World::World(const NetworkConfig& config, uint64_t seed) : seed_(seed), network_(config, seed) {
  BuildStreets(network_, seed, &mesh_);
  for (const Lot& lot : DivideLots(network_, seed)) {
    if (IsOpenLot(lot, seed)) {
      BuildOpenLot(lot, seed, &mesh_);
    } else {
      BuildHouse(lot, seed, &mesh_);
    }
  }
  BuildLandscape(network_, seed, &mesh_);
  BuildStreetFurniture(network_, seed, &mesh_);
  signal_heads_ = BuildSignals(network_, &mesh_);
}

}  // namespace semmap::town
