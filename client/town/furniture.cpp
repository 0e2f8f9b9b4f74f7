#include "client/town/furniture.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "client/town/facade_frame.h"
#include "client/town/props.h"
#include "client/town/random.h"
#include "client/town/street_view.h"
#include "client/town/vegetation.h"
#include "client/town/vehicle_mesh.h"

namespace semmap::town {
namespace {

constexpr uint64_t kFurnitureStream = 91;
constexpr double kClearOfJunction = 8.0;

class FurnitureBuilder {
 public:
  FurnitureBuilder(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh)
      : network_(network), random_(seed, kFurnitureStream), mesh_(mesh) {}

  void Build() {
    for (const Street& street : network_.streets()) {
      const double trees = random_.Chance(0.8) ? 0.75 : 0.35;  // share of the places at the kerb
      for (const int side : {1, -1}) {
        PlaceLamps(street, side);
        PlaceAtKerb(street, side, trees);
        PlaceAtWalls(street, side);
        ParkVehicles(street, side);
        PlaceSigns(street, side);
      }
      if (street.median > 0) HangWires(street);
    }
  }

 private:
  static bool OnBridge(const Street& street, double s) {
    return street.has_bridge && s > street.bridge_from - 3 && s < street.bridge_to + 3;
  }
  glm::vec3 OnPavement(const Street& street, int side, double s, double behind_kerb) const {
    return Lift(street.centre.OffsetPoint(s, side * (street.HalfRoad() + behind_kerb)), kKerbHeight);
  }
  // Towards the road.
  static glm::vec2 RoadWards(const Street& street, int side, double s) {
    return glm::vec2(street.centre.LeftAt(s)) * static_cast<float>(-side);
  }
  // Against the traffic of the lane on this side: what a driver sees from the front.
  static glm::vec2 AgainstTraffic(const Street& street, int side, double s) {
    return glm::vec2(street.centre.TangentAt(s)) * static_cast<float>(side);
  }

  void PlaceLamps(const Street& street, int side) {
    for (double s = side > 0 ? 10 : 22; s < street.centre.length() - 6; s += 24) {
      BuildStreetLamp(OnPavement(street, side, s, 0.45), RoadWards(street, side, s), mesh_);
    }
  }

  // One thing every few metres along the kerb.
  void PlaceAtKerb(const Street& street, int side, double trees) {
    for (double s = kClearOfJunction + 5; s < street.centre.length() - kClearOfJunction; s += 6.3) {
      const double at = s + random_.Uniform(-1.2, 1.2);
      if (OnBridge(street, at)) continue;
      if (random_.Chance(trees)) {
        PlantStreetTree(OnPavement(street, side, at, 0.85));
        if (random_.Chance(0.5)) PlantKerbHedge(street, side, at + 1.0);
      } else if (random_.Chance(0.55)) {
        PlantKerbHedge(street, side, at);
      } else {
        PlaceSmallThing(OnPavement(street, side, at, 0.55), RoadWards(street, side, at));
      }
    }
  }

  void PlantStreetTree(const glm::vec3& foot) {
    mesh_->Box(foot - glm::vec3(0, 0, 0.1F), {1, 0}, {1.2F, 1.2F, 0.115F},
               MakeSurface(Texture::kSoil, ClassId::kTerrain));
    BuildTree(foot, random_.Float(5.5, 9.0), &random_, mesh_);
  }

  // A trimmed hedge between the kerb and those who walk.
  void PlantKerbHedge(const Street& street, int side, double s) {
    const double length = random_.Uniform(2.2, 4.2);
    const double end = std::min(s + length, street.centre.length() - kClearOfJunction);
    if (end - s < 1.0 || OnBridge(street, s) || OnBridge(street, end)) return;
    const auto at = [&](double along) {
      return street.centre.OffsetPoint(along, side * (street.HalfRoad() + 0.4));
    };
    const WallFrame frame = side > 0 ? WallFrame(at(s), at(end)) : WallFrame(at(end), at(s));
    BuildHedge(frame, random_.Float(0.75, 1.15), mesh_);
  }

  void PlaceSmallThing(const glm::vec3& foot, const glm::vec2& to_road) {
    const double kind = random_.Uniform();
    if (kind < 0.14) return BuildBin(foot, -to_road, &random_, mesh_);
    if (kind < 0.24) return BuildHydrant(foot, mesh_);
    if (kind < 0.36) return BuildPlanter(foot, to_road, &random_, mesh_);
    if (kind < 0.46) return BuildBench(foot, -to_road, mesh_);
    if (kind < 0.54) return BuildAdColumn(foot - glm::vec3(to_road * 0.4F, 0), &random_, mesh_);
    if (kind < 0.64) {
      for (int i = 0; i < 3; ++i) {
        BuildBollard(foot + glm::vec3(glm::vec2(-to_road.y, to_road.x) * (1.3F * static_cast<float>(i)), 0),
                     mesh_);
      }
      return;
    }
    if (kind < 0.72) BuildLooseThings(foot, -to_road, &random_, mesh_);
  }

  // Things at the house walls.
  void PlaceAtWalls(const Street& street, int side) {
    for (double s = 12; s < street.centre.length() - 12; s += 11.0) {
      const double at = s + random_.Uniform(-3, 3);
      if (OnBridge(street, at)) continue;
      const glm::vec3 foot = OnPavement(street, side, at, kSidewalkWidth - 0.45);
      const glm::vec2 to_road = RoadWards(street, side, at);
      const double kind = random_.Uniform();
      if (kind < 0.2) {
        BuildLooseThings(foot, to_road, &random_, mesh_);
      } else if (kind < 0.32) {
        BuildCabinet(foot, to_road, &random_, mesh_);
      } else if (kind < 0.4) {
        BuildBusStop(foot - glm::vec3(to_road * -0.35F, 0), to_road, &random_, mesh_);
      } else if (kind < 0.48) {
        BuildBillboard(foot, AgainstTraffic(street, side, at), &random_, mesh_);
      }
    }
  }

  void ParkVehicles(const Street& street, int side) {
    const double density = random_.Uniform(0.2, 0.65);
    for (double s = 14.2; s + 5.8 < street.centre.length() - 13; s += 5.8) {
      if (OnBridge(street, s + 2.9) || !random_.Chance(density)) continue;
      const double middle = s + 2.9 + random_.Uniform(-0.25, 0.25);
      const double lateral = side * (street.HalfRoad() - 1.12 + random_.Uniform(-0.08, 0.08));
      glm::dvec2 forward = street.centre.TangentAt(middle) * static_cast<double>(-side);
      if (random_.Chance(0.1)) forward = -forward;
      const int kind = random_.Chance(0.15) ? 5 : random_.Below(5);
      MeshBuilder vehicle;
      BuildVehicle(kind, random_.Next(), &vehicle);
      glm::mat4 pose = glm::translate(glm::mat4(1), Lift(street.centre.OffsetPoint(middle, lateral), 0.0));
      pose = glm::rotate(pose, static_cast<float>(std::atan2(forward.y, forward.x)), glm::vec3(0, 0, 1));
      mesh_->AppendMoved(vehicle, pose);
    }
  }

  void PlaceSigns(const Street& street, int side) {
    for (double s = 17; s < street.centre.length() - 10; s += 26) {
      const double at = s + random_.Uniform(-4, 4);
      BuildTrafficSign(OnPavement(street, side, at, 0.35), AgainstTraffic(street, side, at),
                       random_.Below(16), mesh_);
    }
  }

  // The tram's overhead line between posts.
  void HangWires(const Street& street) {
    const Surface post = MakeSurface(Texture::kMetal, ClassId::kPole, {110, 120, 116});
    Surface wire = MakeSurface(Texture::kMetal, ClassId::kUnlabeled, {60, 60, 60});
    const double step = street.centre.length() / 3;
    for (int i = 0; i <= 3; ++i) {
      const double s = std::clamp(i * step, 1.0, street.centre.length() - 1.0);
      const glm::vec3 foot = Lift(street.centre.PointAt(s), 0);
      mesh_->Tube(foot, foot + glm::vec3(0, 0, 6.6F), 0.11F, 0.09F, 6, post);
      const glm::vec3 reach(glm::vec2(street.centre.LeftAt(s)) * 2.2F, 0);
      mesh_->Tube(foot - reach + glm::vec3(0, 0, 6.2F), foot + reach + glm::vec3(0, 0, 6.2F), 0.05F, 0.05F, 5,
                  post);
    }
    for (const double track : {-street.median / 4, street.median / 4}) {
      for (double s = 0; s < street.centre.length() - 4; s += 6) {
        const double next = std::min(s + 6, street.centre.length());
        mesh_->Tube(Lift(street.centre.OffsetPoint(s, track), 6.0),
                    Lift(street.centre.OffsetPoint(next, track), 6.0), 0.04F, 0.04F, 4, wire);
      }
    }
  }

  const RoadNetwork& network_;
  Random random_;
  MeshBuilder* mesh_;
};

void AddHousing(const SignalHead& head, MeshBuilder* mesh) {
  const glm::vec3 size = head.for_pedestrians ? glm::vec3(0.2F, 0.3F, 0.6F) : glm::vec3(0.24F, 0.36F, 1.05F);
  const glm::vec3 foot = head.position - glm::vec3(head.facing * (size.x / 2 + 0.01F), size.z / 2);
  mesh->Box(foot, head.facing, size, MakeSurface(Texture::kMetal, ClassId::kTrafficLight, {56, 62, 58}),
            true);
}

}  // namespace

void BuildStreetFurniture(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh) {
  FurnitureBuilder(network, seed, mesh).Build();
}

std::vector<SignalHead> BuildSignals(const RoadNetwork& network, MeshBuilder* mesh) {
  std::vector<SignalHead> heads;
  for (const Junction& junction : network.junctions()) {
    if (!HasCrossings(junction)) continue;
    for (const int side : ArmsOf(junction)) {
      const ArmView arm = ViewArm(network, junction, side);
      const double s = kStopLineAt - 0.4;
      const glm::vec2 outwards(arm.path.TangentAt(s));
      const glm::vec2 to_road = -glm::vec2(arm.path.LeftAt(s));
      const glm::vec3 foot = Lift(arm.path.OffsetPoint(s, arm.street->HalfRoad() + 0.5), kKerbHeight);
      const auto reach = static_cast<float>(kParkingWidth + kLaneWidth / 2 + 0.5);
      BuildSignalPost(foot, to_road, reach, mesh);
      const glm::vec3 near_post = foot + glm::vec3(outwards * 0.3F, 2.9F);
      const glm::vec3 over_lane = foot + glm::vec3(to_road * reach + outwards * 0.2F, 5.4F);
      heads.push_back({junction.id, side, false, near_post, outwards});
      heads.push_back({junction.id, side, false, over_lane, outwards});
      heads.push_back(
          {junction.id, side, true, foot + glm::vec3(to_road * 0.25F - outwards * 0.2F, 2.3F), to_road});
    }
  }
  for (const SignalHead& head : heads) AddHousing(head, mesh);
  return heads;
}

}  // namespace semmap::town
