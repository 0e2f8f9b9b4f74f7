#include "client/town/actors.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "client/town/facade_frame.h"
#include "client/town/pedestrian_mesh.h"
#include "client/town/vehicle_mesh.h"

namespace semmap::town {
namespace {

constexpr float kVehicleRange = 180.0F;
constexpr float kPersonRange = 120.0F;
constexpr float kLightRange = 130.0F;
constexpr glm::vec3 kUp(0, 0, 1);

// The discs of one head, in the plane x = 0, facing +x. Cells of the lights' texture: lit red, yellow, green,
// then the dark ones.
MeshBuilder BuildDiscs(const std::vector<int>& cells, float size) {
  MeshBuilder mesh;
  const float top = size * static_cast<float>(cells.size()) / 2;
  for (size_t i = 0; i < cells.size(); ++i) {
    const float z1 = top - size * static_cast<float>(i);
    const float z0 = z1 - size;
    const CellUv cell = CellOf(cells[i], 4, 4);
    Surface disc = MakeSurface(Texture::kLights, ClassId::kTrafficLight);
    disc.glow = cells[i] < 3 ? 255 : 0;
    disc.grime = 0;
    mesh.QuadUv({0, -size / 2, z0}, {0, size / 2, z0}, {0, size / 2, z1}, {0, -size / 2, z1}, disc, cell.low,
                cell.high);
  }
  return mesh;
}

bool Near(const glm::dvec2& at, const glm::vec3& eye, float range) {
  return glm::distance(glm::vec2(at), glm::vec2(eye)) < range;
}

}  // namespace

Actors::Actors(const World& world, const Simulation& simulation, Renderer* renderer) : world_(world) {
  for (const Vehicle& vehicle : simulation.vehicles().all()) {
    MeshBuilder mesh;
    BuildVehicle(vehicle.kind, vehicle.look, &mesh);
    vehicle_models_.push_back(renderer->AddModel(mesh));
  }
  for (const Pedestrian& person : simulation.pedestrians().all()) {
    std::vector<int> models;
    for (const MeshBuilder& limb : BuildPerson(person.look)) models.push_back(renderer->AddModel(limb));
    person_models_.push_back(std::move(models));
  }
  const std::vector<std::vector<int>> faces = {{0, 4, 5}, {3, 1, 5}, {3, 4, 2}};
  for (const auto& cells : faces) light_models_.push_back(renderer->AddModel(BuildDiscs(cells, 0.32F)));
  light_models_.push_back(renderer->AddModel(BuildDiscs({0, 5}, 0.27F)));
  light_models_.push_back(renderer->AddModel(BuildDiscs({3, 2}, 0.27F)));
}

std::vector<Instance> Actors::Place(const Simulation& simulation, const glm::vec3& eye) const {
  std::vector<Instance> instances;
  PlaceVehicles(simulation, eye, &instances);
  PlacePeople(simulation, eye, &instances);
  PlaceLights(simulation, eye, &instances);
  return instances;
}

void Actors::PlaceVehicles(const Simulation& simulation, const glm::vec3& eye,
                           std::vector<Instance>* instances) const {
  const auto& vehicles = simulation.vehicles().all();
  for (size_t i = 1; i < vehicles.size(); ++i) {
    const Vehicle& vehicle = vehicles[i];
    if (!Near(vehicle.position, eye, kVehicleRange)) continue;
    glm::mat4 pose = glm::translate(glm::mat4(1), glm::vec3(glm::vec2(vehicle.position), 0));
    pose = glm::rotate(pose, static_cast<float>(vehicle.heading), kUp);
    instances->push_back({vehicle_models_[i], pose, true});
  }
}

void Actors::PlacePeople(const Simulation& simulation, const glm::vec3& eye,
                         std::vector<Instance>* instances) const {
  const auto& people = simulation.pedestrians().all();
  for (size_t i = 0; i < people.size(); ++i) {
    const Pedestrian& person = people[i];
    if (!Near(person.position, eye, kPersonRange)) continue;
    glm::mat4 pose = glm::translate(glm::mat4(1),
                                    glm::vec3(glm::vec2(person.position), static_cast<float>(person.ground)));
    pose = glm::rotate(pose, static_cast<float>(person.heading), kUp);
    pose = glm::scale(pose, glm::vec3(static_cast<float>(person.height / 1.75)));
    const double stride = std::min(1.0, person.speed / 1.2);
    const std::vector<glm::mat4> joints = WalkingPose(person.travelled, stride);
    for (size_t k = 0; k < joints.size(); ++k)
      instances->push_back({person_models_[i][k], pose * joints[k], true});
  }
}

void Actors::PlaceLights(const Simulation& simulation, const glm::vec3& eye,
                         std::vector<Instance>* instances) const {
  for (const SignalHead& head : world_.signal_heads()) {
    if (!Near(glm::dvec2(head.position), eye, kLightRange)) continue;
    const Signals& signals = simulation.signals();
    const int model = head.for_pedestrians ? (signals.PedestriansMayStart(head.junction) ? 4 : 3)
                                           : static_cast<int>(signals.VehicleLight(head.junction, head.side));
    glm::mat4 pose = glm::translate(glm::mat4(1), head.position + glm::vec3(head.facing * 0.012F, 0));
    pose = glm::rotate(pose, std::atan2(head.facing.y, head.facing.x), kUp);
    instances->push_back({light_models_[static_cast<size_t>(model)], pose, false});
  }
}

}  // namespace semmap::town
