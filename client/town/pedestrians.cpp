#include "client/town/pedestrians.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "client/town/street_view.h"

namespace semmap::town {
namespace {
constexpr uint64_t kPedestrianStream = 121;
constexpr double kWalkLine = 1.75;  // metres behind the kerb
}  // namespace

Pedestrians::Pedestrians(const RoadNetwork& network, const Route& route, int count, uint64_t seed)
    : network_(network), random_(seed, kPedestrianStream) {
  MakeWalkways();
  Place(route, count);
}

int Pedestrians::AddWalkway(Path path, int from, int to, int crossing_at) {
  const int id = static_cast<int>(walkways_.size());
  walkways_.push_back({std::move(path), from, to, crossing_at});
  walkways_at_[static_cast<size_t>(from)].push_back(id);
  walkways_at_[static_cast<size_t>(to)].push_back(id);
  return id;
}

void Pedestrians::MakeWalkways() {
  walkways_at_.resize(network_.streets().size() * 4);
  for (const Street& street : network_.streets()) {  // walkway 2 * street + (0 left, 1 right)
    for (const int side : {1, -1}) {
      AddWalkway(street.centre.Offset(side * (street.HalfRoad() + kWalkLine)), NodeOf(street, side, false),
                 NodeOf(street, side, true), -1);
    }
  }
  for (const Junction& junction : network_.junctions()) {
    const std::vector<int> arms = ArmsOf(junction);
    // The node on the left or right of an arm, looking outwards.
    const auto node = [&](int arm, int side) {
      const Street& street = *ViewArm(network_, junction, arm).street;
      const bool at_end = street.from != junction.id;
      return NodeOf(street, at_end ? -side : side, at_end);
    };
    for (size_t i = 0; i < arms.size(); ++i) {
      const int a = arms[i];
      const int b = arms[(i + 1) % arms.size()];
      AddWalkway(Path(EdgeCurve(network_, junction, a, b, kWalkLine)), node(a, 1), node(b, -1), -1);
      if (!HasCrossings(junction)) continue;
      const ArmView arm = ViewArm(network_, junction, a);
      const double half = arm.street->HalfRoad() + kWalkLine;
      const double s = (kCrossingFrom + kCrossingTo) / 2;
      AddWalkway(Path({arm.path.OffsetPoint(0.3, half), arm.path.OffsetPoint(s, half - 1.2),
                       arm.path.OffsetPoint(s, 1.2 - half), arm.path.OffsetPoint(0.3, -half)}),
                 node(a, 1), node(a, -1), junction.id);
    }
  }
}

void Pedestrians::Place(const Route& route, int count) {
  for (int i = 0; i < count; ++i) {
    Pedestrian person;
    person.look = random_.Next();
    person.pace = random_.Uniform(1.05, 1.65);
    person.height = random_.Uniform(1.55, 1.92);
    // Spread over the route's streets, those at its beginning first.
    const size_t leg = static_cast<size_t>(i / 4) % route.lanes.size();
    const int street = network_.lanes()[static_cast<size_t>(route.lanes[leg])].street;
    person.edge = 2 * street + random_.Below(2);
    person.reversed = random_.Chance(0.5);
    person.s = random_.Uniform(0, walkways_[static_cast<size_t>(person.edge)].path.length());
    person.beside = random_.Uniform(-0.35, 0.35);
    person.next_edge = ChooseNext(person);
    person.position = Target(person);
    person.heading = 0;
    people_.push_back(person);
  }
}

int Pedestrians::EndNode(const Pedestrian& person) const {
  const Walkway& way = walkways_[static_cast<size_t>(person.edge)];
  return person.reversed ? way.from : way.to;
}

int Pedestrians::ChooseNext(const Pedestrian& person) {
  std::vector<int> options;
  for (const int id : walkways_at_[static_cast<size_t>(EndNode(person))]) {
    if (id == person.edge) continue;
    const bool crossing = walkways_[static_cast<size_t>(id)].crossing_at >= 0;
    if (!crossing || random_.Chance(0.5)) options.push_back(id);
  }
  return options.empty() ? person.edge : random_.Pick(options);
}

glm::dvec2 Pedestrians::Target(const Pedestrian& person) const {
  const Path& path = walkways_[static_cast<size_t>(person.edge)].path;
  const double s = person.reversed ? path.length() - person.s : person.s;
  return path.OffsetPoint(s, person.beside);
}

void Pedestrians::Advance(Pedestrian* person, double seconds, const Signals& signals) {
  const double length = walkways_[static_cast<size_t>(person->edge)].path.length();
  person->waiting = false;
  person->s += person->pace * seconds;
  if (person->s < length) return;
  const Walkway& next = walkways_[static_cast<size_t>(person->next_edge)];
  if (next.crossing_at >= 0 && !signals.PedestriansMayStart(next.crossing_at)) {
    person->s = length;
    person->waiting = true;
    return;
  }
  const int node = EndNode(*person);
  person->s -= length;
  person->edge = person->next_edge;
  person->reversed = next.from != node;
  person->next_edge = ChooseNext(*person);
}

// The body follows the walkway's point smoothly, so that corners are rounded.
void Pedestrians::Follow(Pedestrian* person, double seconds) const {
  const glm::dvec2 before = person->position;
  const glm::dvec2 way = Target(*person) - before;
  const double distance = glm::length(way);
  const double step = std::min(distance, person->pace * 1.15 * seconds);
  if (distance > 1e-6) person->position += way * (step / distance);
  person->speed = step / seconds;
  person->travelled += step;
  if (step > 0.2 * seconds) {
    const double wanted = std::atan2(way.y, way.x);
    const double turn = std::remainder(wanted - person->heading, 2 * 3.14159265358979323846);
    person->heading += std::clamp(turn, -4.0 * seconds, 4.0 * seconds);
  }
  const bool crossing = walkways_[static_cast<size_t>(person->edge)].crossing_at >= 0;
  const double wanted_ground =
      crossing && person->s > 1.5 &&
              person->s < walkways_[static_cast<size_t>(person->edge)].path.length() - 1.5
          ? 0.0
          : kKerbHeight;
  person->ground += std::clamp(wanted_ground - person->ground, -0.4 * seconds, 0.4 * seconds);
}

void Pedestrians::Step(double seconds, const Signals& signals) {
  for (Pedestrian& person : people_) {
    Advance(&person, seconds, signals);
    Follow(&person, seconds);
  }
}

void Pedestrians::AddDemand(std::vector<JunctionDemand>* demands) const {
  for (const Pedestrian& person : people_) {
    const Walkway& way = walkways_[static_cast<size_t>(person.edge)];
    if (way.crossing_at >= 0) (*demands)[static_cast<size_t>(way.crossing_at)].occupied = true;
    const Walkway& next = walkways_[static_cast<size_t>(person.next_edge)];
    if (person.waiting) (*demands)[static_cast<size_t>(next.crossing_at)].pedestrian_waits = true;
  }
}

}  // namespace semmap::town
