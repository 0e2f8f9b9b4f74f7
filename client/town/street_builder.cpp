#include "client/town/street_builder.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

#include "client/town/random.h"
#include "client/town/street_view.h"

namespace semmap::town {
namespace {

constexpr uint64_t kStreetStream = 41;
constexpr double kStep = 2.5;
constexpr double kPatchHeight = 0.006;
constexpr double kPaintHeight = 0.012;
constexpr double kKerbTop = 0.16;
constexpr double kGauge = 1.435;

class StreetBuilder {
 public:
  StreetBuilder(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh)
      : network_(network), random_(seed, kStreetStream), mesh_(mesh) {}

  void Build() {
    for (const Street& street : network_.streets()) BuildStreet(street);
    for (const Junction& junction : network_.junctions()) {
      if (junction.IsBend()) {
        BuildBend(junction);
      } else {
        BuildJunction(junction);
      }
      BuildCorners(junction);
      if (HasCrossings(junction)) PaintArms(junction);
    }
  }

 private:
  Texture AnyAsphalt() {
    return static_cast<Texture>(static_cast<int>(Texture::kAsphalt0) + random_.Below(3));
  }
  Texture AnyPaving() { return random_.Chance(0.5) ? Texture::kPavingSlabs0 : Texture::kPavingSlabs1; }
  void Shift() { mesh_->SetTextureShift({random_.Float(0, 30), random_.Float(0, 30)}); }

  // Points along a path at a lateral offset.
  static std::vector<glm::vec3> Line(const Path& path, double from, double to, double lateral, double z) {
    const int count = std::max(1, static_cast<int>(std::ceil((to - from) / kStep)));
    std::vector<glm::vec3> points;
    for (int i = 0; i <= count; ++i) {
      points.push_back(Lift(path.OffsetPoint(from + (to - from) * i / count, lateral), z));
    }
    return points;
  }

  void Strip(const Path& path, double from, double to, double right, double left, double z,
             const Surface& surface) {
    mesh_->Ribbon(Line(path, from, to, left, z), Line(path, from, to, right, z), surface);
  }

  // A vertical face; the viewer sees the points from left to right.
  void Face(const std::vector<glm::vec3>& points, double height, const Surface& surface) {
    const glm::vec3 up(0, 0, height);
    for (size_t i = 0; i + 1 < points.size(); ++i) {
      mesh_->Quad(points[i], points[i + 1], points[i + 1] + up, points[i] + up, surface);
    }
  }

  void BuildStreet(const Street& street) {
    const Path& path = street.centre;
    const double length = path.length();
    const double half = street.HalfRoad();
    const double lane_edge = half - kParkingWidth;
    Shift();
    const Surface road = MakeSurface(AnyAsphalt(), ClassId::kRoad);
    Strip(path, 0, length, street.median / 2, lane_edge, 0, road);
    Shift();
    Strip(path, 0, length, -lane_edge, -street.median / 2, 0, road);
    BuildParking(street, lane_edge, half);
    if (street.median > 0) BuildTrackBed(path, 0, length, street.median / 2);
    BuildPavement(street, +1);
    BuildPavement(street, -1);
    PaintLines(street, lane_edge);
    ScatterPatches(street);
  }

  void BuildParking(const Street& street, double lane_edge, double half) {
    const Surface bay = MakeSurface(random_.Chance(0.6) ? Texture::kSetts : AnyAsphalt(), ClassId::kRoad);
    Shift();
    Strip(street.centre, 0, street.centre.length(), lane_edge, half, 0, bay);
    Strip(street.centre, 0, street.centre.length(), -half, -lane_edge, 0, bay);
  }

  void BuildPavement(const Street& street, int side) {
    const Path& path = street.centre;
    const double half = street.HalfRoad();
    auto kerb = Line(path, 0, path.length(), side * half, 0);
    auto kerb_back = Line(path, 0, path.length(), side * (half + kKerbTop), kKerbHeight);
    auto outer = Line(path, 0, path.length(), side * (half + kSidewalkWidth), kKerbHeight);
    if (side < 0) {
      for (auto* line : {&kerb, &kerb_back, &outer}) std::reverse(line->begin(), line->end());
    }
    Pavement(kerb, kerb_back, outer);
  }

  // All three lines as a viewer on the road sees them, left to right.
  void Pavement(const std::vector<glm::vec3>& kerb, const std::vector<glm::vec3>& kerb_back,
                const std::vector<glm::vec3>& outer) {
    Shift();
    const Surface stone = MakeSurface(Texture::kAshlar1, ClassId::kSideWalk, {220, 216, 212});
    Face(kerb, kKerbHeight, stone);
    std::vector<glm::vec3> kerb_top = kerb;
    for (glm::vec3& point : kerb_top) point.z = static_cast<float>(kKerbHeight);
    mesh_->Ribbon(kerb_back, kerb_top, stone);
    mesh_->Ribbon(
        outer, kerb_back,
        MakeSurface(AnyPaving(), ClassId::kSideWalk, Shade({255, 250, 244}, random_.Uniform(0.85, 1))));
  }

  void BuildTrackBed(const Path& path, double from, double to, double half) {
    Shift();
    Strip(path, from, to, -half, half, 0.02, MakeSurface(Texture::kBallast, ClassId::kRailTrack));
    for (const double track : {-half / 2, half / 2}) {
      BuildSleepers(path, from, to, track);
      BuildRails(path, from, to, track, 0.1);
    }
  }

  void BuildSleepers(const Path& path, double from, double to, double track) {
    const Surface sleeper = MakeSurface(Texture::kConcrete0, ClassId::kRailTrack, {210, 200, 190});
    for (double s = from + 0.4; s < to - 0.3; s += 1.2) {
      const glm::dvec2 forward = path.LeftAt(s);
      mesh_->Box(Lift(path.OffsetPoint(s, track), 0.0), glm::vec2(forward), {2.3F, 0.24F, 0.06F}, sleeper);
    }
  }

  void BuildRails(const Path& path, double from, double to, double track, double height) {
    const Surface rail = MakeSurface(Texture::kMetal, ClassId::kRailTrack, {170, 150, 136});
    for (const double lateral : {track - kGauge / 2, track + kGauge / 2}) {
      Strip(path, from, to, lateral - 0.05, lateral + 0.05, height, rail);
      if (height < 0.05) continue;
      Face(Line(path, from, to, lateral + 0.05, 0.0), height, rail);
      auto right = Line(path, from, to, lateral - 0.05, 0.0);
      std::reverse(right.begin(), right.end());
      Face(right, height, rail);
    }
  }

  void Paint(const Path& path, double from, double to, double lateral, double width) {
    Shift();
    Strip(path, from, to, lateral - width / 2, lateral + width / 2, kPaintHeight,
          MakeSurface(Texture::kPaint, ClassId::kRoadLine));
  }

  void PaintLines(const Street& street, double lane_edge) {
    const Path& path = street.centre;
    const double length = path.length();
    const double solid = 18;
    for (const double side : {-1.0, 1.0})
      Paint(path, kStopLineAt, length - kStopLineAt, side * lane_edge, 0.12);
    if (street.median > 0) {
      for (const double side : {-1.0, 1.0})
        Paint(path, 1.0, length - 1.0, side * (street.median / 2 + 0.12), 0.14);
      return;
    }
    Paint(path, kStopLineAt, solid, 0, 0.14);
    Paint(path, length - solid, length - kStopLineAt, 0, 0.14);
    for (double s = solid + 2; s + 3 < length - solid; s += 5.5) Paint(path, s, s + 3, 0, 0.14);
    PaintParkingBays(street, lane_edge);
  }

  void PaintParkingBays(const Street& street, double lane_edge) {
    for (const int side : {-1, 1}) {
      for (double s = 14; s < street.centre.length() - 14; s += 5.8) {
        const double a = side * lane_edge;
        const double b = side * street.HalfRoad();
        Strip(street.centre, s, s + 0.1, std::min(a, b), std::max(a, b), kPaintHeight,
              MakeSurface(Texture::kPaint, ClassId::kRoadLine, {215, 215, 210}));
      }
    }
  }

  // Manholes and mended places.
  void ScatterPatches(const Street& street) {
    const double length = street.centre.length();
    const int count = static_cast<int>(length / 6);
    for (int i = 0; i < count; ++i) {
      const double s = random_.Uniform(7, length - 7);
      const double lateral = random_.Uniform(-street.HalfRoad() + 1, street.HalfRoad() - 1);
      if (std::abs(lateral) < street.median / 2 + 0.8) continue;
      const bool manhole = random_.Chance(0.3);
      const double size = manhole ? 0.75 : random_.Uniform(0.8, 2.4);
      const int cell = manhole ? random_.Integer(4, 7) : random_.Integer(8, 15);
      Decal(street.centre, s, lateral, size, size * (manhole ? 1 : random_.Uniform(0.7, 1.8)), cell,
            kPatchHeight, ClassId::kRoad);
    }
  }

  // One cell of the arrows' texture, its top pointing along the path.
  void Decal(const Path& path, double s, double lateral, double width, double length, int cell, double z,
             ClassId class_id) {
    const glm::dvec2 t = path.TangentAt(s) * (length / 2);
    const glm::dvec2 left = path.LeftAt(s) * (width / 2);
    const glm::dvec2 at = path.OffsetPoint(s, lateral);
    const float u = static_cast<float>(cell % 4) / 4;
    const float v = 1.0F - static_cast<float>(cell / 4 + 1) / 4;
    mesh_->CutQuad(
        {Lift(at + left - t, z), Lift(at - left - t, z), Lift(at - left + t, z), Lift(at + left + t, z)},
        {u, v}, {u + 0.25F, v + 0.25F}, {0, 0, 1}, MakeSurface(Texture::kRoadArrows, class_id));
  }

  void BuildJunction(const Junction& junction) {
    Shift();
    const Surface road = MakeSurface(AnyAsphalt(), ClassId::kRoad);
    std::vector<glm::dvec2> rim;
    const std::vector<int> arms = ArmsOf(junction);
    for (size_t i = 0; i < arms.size(); ++i) {
      const auto curve = EdgeCurve(network_, junction, arms[i], arms[(i + 1) % arms.size()], 0);
      rim.insert(rim.end(), curve.begin(), curve.end());
    }
    for (size_t i = 0; i < rim.size(); ++i) {
      mesh_->Triangle(Lift(junction.centre, 0), Lift(rim[i], 0), Lift(rim[(i + 1) % rim.size()], 0), road);
    }
    BuildTramCrossing(junction);
  }

  // The tram's rails run on through the junction, sunk into the road.
  void BuildTramCrossing(const Junction& junction) {
    const int west = junction.street[static_cast<size_t>(Side::kWest)];
    const int east = junction.street[static_cast<size_t>(Side::kEast)];
    double median = 0;
    for (const int id : {west, east}) {
      if (id >= 0) median = std::max(median, network_.streets()[static_cast<size_t>(id)].median);
    }
    if (median <= 0) return;
    const glm::dvec2 half(junction.half_size, 0);
    const Path path({junction.centre - half, junction.centre, junction.centre + half});
    for (const double track : {-median / 4, median / 4}) {
      if (west < 0 || east < 0) {
        BuildRails(path, west < 0 ? junction.half_size * 0.7 : 0,
                   east < 0 ? junction.half_size * 1.3 : path.length(), track, kPaintHeight);
      } else {
        BuildRails(path, 0, path.length(), track, kPaintHeight);
      }
    }
  }

  void BuildBend(const Junction& junction) {
    const std::vector<int> arms = ArmsOf(junction);
    const bool in_order = (arms[0] + 1) % kSides == arms[1];
    const int a = in_order ? arms[0] : arms[1];
    const int b = in_order ? arms[1] : arms[0];
    const auto inner = EdgeCurve(network_, junction, a, b, 0);
    auto outer = EdgeCurve(network_, junction, b, a, 0);
    std::reverse(outer.begin(), outer.end());
    std::vector<glm::vec3> left;
    std::vector<glm::vec3> right;
    std::vector<glm::dvec2> middle;
    for (size_t i = 0; i < inner.size(); ++i) {
      left.push_back(Lift(outer[i], 0));
      right.push_back(Lift(inner[i], 0));
      middle.push_back((outer[i] + inner[i]) * 0.5);
    }
    Shift();
    mesh_->Ribbon(left, right, MakeSurface(AnyAsphalt(), ClassId::kRoad));
    const Path centre(middle);
    Paint(centre, 0, centre.length(), 0, 0.14);
    for (const double side : {-1.0, 1.0}) Paint(centre, 0, centre.length(), side * kLaneWidth, 0.12);
  }

  void BuildCorners(const Junction& junction) {
    const std::vector<int> arms = ArmsOf(junction);
    for (size_t i = 0; i < arms.size(); ++i) {
      const int a = arms[i];
      const int b = arms[(i + 1) % arms.size()];
      const auto line = [&](double extra, double z) {
        std::vector<glm::vec3> points;
        for (const glm::dvec2& point : EdgeCurve(network_, junction, a, b, extra))
          points.push_back(Lift(point, z));
        std::reverse(points.begin(), points.end());
        return points;
      };
      Pavement(line(0, 0), line(kKerbTop, kKerbHeight), line(kSidewalkWidth, kKerbHeight));
    }
  }

  void PaintArms(const Junction& junction) {
    for (const int side : ArmsOf(junction)) {
      const ArmView arm = ViewArm(network_, junction, side);
      const double lane_edge = arm.street->HalfRoad() - kParkingWidth;
      for (double x = -arm.street->HalfRoad() + 0.5; x < arm.street->HalfRoad() - 0.3; x += 1.0) {
        Paint(arm.path, kCrossingFrom, kCrossingTo, x, 0.5);
      }
      const double inner = arm.street->median / 2;
      Shift();
      Strip(arm.path, kStopLineAt, kStopLineAt + 0.4, inner + 0.1, lane_edge, kPaintHeight,
            MakeSurface(Texture::kPaint, ClassId::kRoadLine));
      PaintArrow(junction, arm);
    }
  }

  // An arrow on the lane that leads to the junction, pointing at it.
  void PaintArrow(const Junction& junction, const ArmView& arm) {
    const Path inwards = arm.path.Reversed();
    const bool straight_on = junction.street[static_cast<size_t>(OppositeOf(arm.side))] >= 0;
    const int cell = straight_on ? 0 : 1 + random_.Below(2);
    const double s = inwards.length() - kStopLineAt - 5.0;
    for (const double back : {0.0, 14.0}) {
      Decal(inwards, s - back, -arm.street->LaneOffset(), 1.5, 3.6, cell, kPaintHeight + 0.002,
            ClassId::kRoadLine);
    }
  }

  const RoadNetwork& network_;
  Random random_;
  MeshBuilder* mesh_;
};

}  // namespace

void BuildStreets(const RoadNetwork& network, uint64_t seed, MeshBuilder* mesh) {
  StreetBuilder(network, seed, mesh).Build();
}

}  // namespace semmap::town
