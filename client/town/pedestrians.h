#pragma once

#include <cstdint>
#include <vector>

#include "client/town/random.h"
#include "client/town/road_network.h"
#include "client/town/signals.h"

namespace semmap::town {

struct Pedestrian {
  uint64_t look = 0;
  double pace = 1.35;  // m/s when walking
  double height = 1.75;
  int edge = 0;           // of the walkways
  bool reversed = false;  // walks it from its end
  double s = 0;           // along the edge, the way one walks
  double beside = 0;      // metres left of the walkway's line, looking along the edge
  bool waiting = false;
  int next_edge = -1;
  double travelled = 0;
  double speed = 0;
  glm::dvec2 position{0, 0};
  double heading = 0;
  double ground = 0;  // height of the surface below
};

// People on the pavements, who cross the streets on the zebra crossings when the lights let them.
class Pedestrians {
 public:
  Pedestrians(const RoadNetwork& network, const Route& route, int count, uint64_t seed);

  void Step(double seconds, const Signals& signals);
  const std::vector<Pedestrian>& all() const { return people_; }
  void AddDemand(std::vector<JunctionDemand>* demands) const;

 private:
  // A piece of pavement, a street corner or a crossing.
  struct Walkway {
    Path path;
    int from = 0;  // nodes
    int to = 0;
    int crossing_at = -1;  // junction whose lights say when to cross; -1: no crossing
  };
  void MakeWalkways();
  int AddWalkway(Path path, int from, int to, int crossing_at);
  static int NodeOf(const Street& street, int side, bool at_end) {
    return street.id * 4 + (side > 0 ? 0 : 2) + (at_end ? 1 : 0);
  }
  void Place(const Route& route, int count);
  int ChooseNext(const Pedestrian& person);
  void Advance(Pedestrian* person, double seconds, const Signals& signals);
  void Follow(Pedestrian* person, double seconds) const;
  glm::dvec2 Target(const Pedestrian& person) const;
  int EndNode(const Pedestrian& person) const;

  const RoadNetwork& network_;
  std::vector<Walkway> walkways_;
  std::vector<std::vector<int>> walkways_at_;  // by node
  std::vector<Pedestrian> people_;
  Random random_;
};

}  // namespace semmap::town
