#pragma once

#include <vector>

#include "client/town/renderer.h"
#include "client/town/simulation.h"
#include "client/town/world.h"

namespace semmap::town {

// The models of everything that moves or changes, and where they stand at the moment. Bound to one renderer.
class Actors {
 public:
  // Uploads the models to `renderer`, which must outlive this.
  Actors(const World& world, const Simulation& simulation, Renderer* renderer);

  // What is near enough to `eye` to be seen.
  std::vector<Instance> Place(const Simulation& simulation, const glm::vec3& eye) const;

 private:
  void PlaceVehicles(const Simulation& simulation, const glm::vec3& eye,
                     std::vector<Instance>* instances) const;
  void PlacePeople(const Simulation& simulation, const glm::vec3& eye,
                   std::vector<Instance>* instances) const;
  void PlaceLights(const Simulation& simulation, const glm::vec3& eye,
                   std::vector<Instance>* instances) const;

  const World& world_;
  std::vector<int> vehicle_models_;  // by vehicle; that of the ego vehicle is not drawn
  std::vector<std::vector<int>> person_models_;
  std::vector<int> light_models_;  // by Light; then pedestrians' red and green
};

}  // namespace semmap::town
