#include "client/town/facade.h"

#include <algorithm>
#include <cmath>

#include "client/town/facade_frame.h"

namespace semmap::town {
namespace {

constexpr uint64_t kStylePurpose = 61;
constexpr float kReveal = 0.14F;

Surface Wall(const HouseStyle& style) {
  Surface surface = MakeSurface(style.wall, ClassId::kBuilding, style.wall_tint);
  return surface;
}

Surface Trim(const HouseStyle& style, double shade = 1.0) {
  return MakeSurface(Texture::kConcrete0, ClassId::kBuilding, Shade(style.trim_tint, shade));
}

// One floor of a street facade.
class FacadeBuilder {
 public:
  FacadeBuilder(const HouseStyle& style, const WallFrame& frame, Random* random, MeshBuilder* mesh)
      : style_(style), frame_(frame), random_(random), mesh_(mesh) {
    bays_ = std::max(1, static_cast<int>(std::lround((frame.width() - 0.8F) / style.bay_width)));
    bay_ = frame.width() / static_cast<float>(bays_);
  }

  void Build(float z0) {
    float z = z0;
    BuildGroundFloor(z, style_.ground_height);
    z = style_.ground_height;
    for (int floor = 1; floor < style_.floors; ++floor) {
      BuildFloor(z, style_.floor_height, floor);
      z += style_.floor_height;
    }
    if (style_.cornice) BuildCornice(z);
    if (random_->Chance(0.7)) BuildDrainPipe(z);
  }

 private:
  float WindowWidth() const { return std::min(style_.window_width, bay_ - 0.5F); }

  void BuildFloor(float z, float height, int floor) {
    const float sill = z + 0.85F;
    const float head = std::min(sill + style_.window_height, z + height - 0.3F);
    WallWithOpenings(z, z + height, sill, head);
    for (int bay = 0; bay < bays_; ++bay) {
      const float middle = (static_cast<float>(bay) + 0.5F) * bay_;
      BuildWindow(middle - WindowWidth() / 2, sill, middle + WindowWidth() / 2, head);
      if (style_.balconies && floor >= 1 && (bay + floor) % 2 == 0) BuildBalcony(middle, z);
    }
    if (style_.bands) frame_.Ledge(mesh_, 0, z - 0.09F, frame_.width(), z + 0.09F, 0.08F, Trim(style_));
  }

  // The wall around one row of windows: a band below, a band above, piers between.
  void WallWithOpenings(float z0, float z1, float sill, float head) {
    const Surface wall = Wall(style_);
    const float w = frame_.width();
    frame_.Rect(mesh_, 0, z0, w, sill, 0, wall);
    frame_.Rect(mesh_, 0, head, w, z1, 0, wall);
    float left = 0;
    for (int bay = 0; bay <= bays_; ++bay) {
      const float right = bay == bays_ ? w : (static_cast<float>(bay) + 0.5F) * bay_ - WindowWidth() / 2;
      frame_.Rect(mesh_, left, sill, right, head, 0, wall);
      left = right + WindowWidth();
    }
  }

  void BuildReveal(float x0, float z0, float x1, float z1) {
    const Surface side = style_.surrounds
                             ? Trim(style_, 0.8)
                             : MakeSurface(style_.wall, ClassId::kBuilding, Shade(style_.wall_tint, 0.75));
    const auto at = [&](float x, float z, float out) { return frame_.At(x, z, out); };
    mesh_->Quad(at(x0, z0, 0), at(x0, z0, -kReveal), at(x0, z1, -kReveal), at(x0, z1, 0), side);
    mesh_->Quad(at(x1, z0, -kReveal), at(x1, z0, 0), at(x1, z1, 0), at(x1, z1, -kReveal), side);
    mesh_->Quad(at(x0, z1, -kReveal), at(x1, z1, -kReveal), at(x1, z1, 0), at(x0, z1, 0), side);
    mesh_->Quad(at(x0, z0, 0), at(x1, z0, 0), at(x1, z0, -kReveal), at(x0, z0, -kReveal), side);
  }

  Surface Glass(Texture texture) {
    Surface glass =
        MakeSurface(texture, ClassId::kBuilding, Shade({255, 255, 255}, random_->Uniform(0.8, 1.0)));
    glass.glow = random_->Chance(0.45) ? static_cast<uint8_t>(random_->Integer(90, 255)) : uint8_t{0};
    glass.grime = 0.35F;
    return glass;
  }

  void BuildWindow(float x0, float z0, float x1, float z1) {
    BuildReveal(x0, z0, x1, z1);
    const CellUv cell = CellOf(random_->Below(16), 4, 4);
    frame_.RectUv(mesh_, x0, z0, x1, z1, -kReveal, Glass(style_.windows), cell.low, cell.high);
    frame_.Ledge(mesh_, x0 - 0.08F, z0 - 0.1F, x1 + 0.08F, z0, 0.14F, Trim(style_));
    if (!style_.surrounds) return;
    const Surface stone = Trim(style_);
    frame_.Ledge(mesh_, x0 - 0.16F, z1, x1 + 0.16F, z1 + 0.22F, 0.1F, stone);
    frame_.Rect(mesh_, x0 - 0.16F, z0, x0, z1, 0.03F, stone);
    frame_.Rect(mesh_, x1, z0, x1 + 0.16F, z1, 0.03F, stone);
  }

  void BuildBalcony(float middle, float z) {
    const float half = std::min(bay_ * 0.46F, 1.25F);
    frame_.Ledge(mesh_, middle - half, z - 0.05F, middle + half, z + 0.12F, 0.9F, Trim(style_, 0.9));
    const Surface rail = MakeSurface(Texture::kRailing, ClassId::kBuilding,
                                     Shade({255, 255, 255}, random_->Uniform(0.4, 1.0)));
    const auto panel = [&](const glm::vec3& a, const glm::vec3& b, const glm::vec3& normal) {
      const glm::vec3 up(0, 0, 0.95F);
      mesh_->CutQuad({a, b, b + up, a + up}, {0, 0}, {glm::distance(a, b) / 1.2F, 1}, normal, rail);
    };
    const float base = z + 0.12F;
    panel(frame_.At(middle - half, base, 0.88F), frame_.At(middle + half, base, 0.88F), frame_.out());
    panel(frame_.At(middle - half, base, 0), frame_.At(middle - half, base, 0.88F), frame_.out());
    panel(frame_.At(middle + half, base, 0.88F), frame_.At(middle + half, base, 0), frame_.out());
    if (random_->Chance(0.4)) {
      const Surface plants = MakeSurface(Texture::kHedge, ClassId::kBuilding);
      frame_.Ledge(mesh_, middle - half, base + 0.5F, middle + half * 0.8F, base + 0.85F, 0.98F, plants);
    }
  }

  void BuildGroundFloor(float z0, float height) {
    if (style_.ground == GroundFloor::kShops) return BuildShops(z0, height);
    const float sill = std::max(z0 + 0.6F, 1.2F);
    const float head = height - 0.45F;
    const int door = random_->Below(bays_);
    const bool plinth = style_.ground == GroundFloor::kPlinth;
    WallWithOpenings(z0, height, sill, head);
    if (plinth) {
      frame_.Ledge(mesh_, 0, z0, frame_.width(), 0.95F, 0.07F,
                   MakeSurface(Texture::kRubble, ClassId::kBuilding, style_.trim_tint));
    }
    for (int bay = 0; bay < bays_; ++bay) {
      const float middle = (static_cast<float>(bay) + 0.5F) * bay_;
      if (bay == door) {
        BuildDoor(middle, z0, head);
      } else {
        BuildWindow(middle - WindowWidth() / 2, sill, middle + WindowWidth() / 2, head);
      }
    }
    if (random_->Chance(0.5)) AddGraffiti(z0);
    if (random_->Chance(0.35)) AddPoster(z0);
  }

  void BuildDoor(float middle, float z0, float head) {
    const float half = 0.62F;
    const CellUv cell = CellOf(random_->Below(8), 4, 2);
    Surface door = MakeSurface(Texture::kDoors, ClassId::kBuilding);
    door.grime = 0.5F;
    frame_.RectUv(mesh_, middle - half, z0, middle + half, head, 0.09F, door, cell.low, cell.high);
    const Surface stone = Trim(style_, 0.95);
    frame_.Ledge(mesh_, middle - half - 0.22F, z0, middle - half, head, 0.16F, stone);
    frame_.Ledge(mesh_, middle + half, z0, middle + half + 0.22F, head, 0.16F, stone);
    frame_.Ledge(mesh_, middle - half - 0.3F, head, middle + half + 0.3F, head + 0.26F, 0.3F, stone);
    frame_.Ledge(mesh_, middle - half, z0, middle + half, z0 + 0.15F, 0.4F, stone);
  }

  void BuildShops(float z0, float height) {
    const float sign = height - 0.85F;
    const int shops = std::max(1, static_cast<int>(std::lround(frame_.width() / 6.5F)));
    const float width = frame_.width() / static_cast<float>(shops);
    for (int i = 0; i < shops; ++i) {
      const float x0 = static_cast<float>(i) * width;
      BuildShop(x0, x0 + width, z0, sign);
      BuildShopSign(x0, x0 + width, sign, height);
      frame_.Ledge(mesh_, x0, z0, x0 + 0.3F, sign, 0.12F, Trim(style_, 0.85));
      if (style_.awnings && random_->Chance(0.7)) BuildAwning(x0 + 0.4F, x0 + width - 0.3F, sign);
    }
    frame_.Ledge(mesh_, 0, height - 0.12F, frame_.width(), height, 0.22F, Trim(style_));
  }

  void BuildShop(float x0, float x1, float z0, float sign) {
    const auto texture = static_cast<Texture>(static_cast<int>(Texture::kShops0) + random_->Below(8));
    Surface front = MakeSurface(texture, ClassId::kBuilding);
    front.glow = random_->Chance(0.8) ? uint8_t{200} : uint8_t{0};
    front.grime = 0.3F;
    const CellUv cell = CellOf(random_->Below(2), 1, 2);
    frame_.RectUv(mesh_, x0, z0, x1, sign, 0, front, cell.low, cell.high);
  }

  void BuildShopSign(float x0, float x1, float z0, float z1) {
    frame_.Rect(mesh_, x0, z0, x1, z1, 0, Wall(style_));
    const auto texture = static_cast<Texture>(static_cast<int>(Texture::kShopSigns0) + random_->Below(4));
    Surface board = MakeSurface(texture, ClassId::kBuilding);
    board.glow = random_->Chance(0.6) ? uint8_t{180} : uint8_t{0};
    board.grime = 0.3F;
    const CellUv cell = CellOf(random_->Below(8), 1, 8);
    frame_.Ledge(mesh_, x0 + 0.3F, z0 + 0.04F, x1 - 0.1F, z1 - 0.18F, 0.14F, Trim(style_, 0.6));
    frame_.RectUv(mesh_, x0 + 0.3F, z0 + 0.04F, x1 - 0.1F, z1 - 0.18F, 0.15F, board, cell.low, cell.high);
    if (random_->Chance(0.45)) BuildHangingSign((x0 + x1) / 2, z1 + 0.5F, board);
  }

  void BuildHangingSign(float x, float z, const Surface& board) {
    const CellUv cell = CellOf(random_->Below(8), 1, 8);
    const glm::vec3 a = frame_.At(x, z, 0.15F);
    const glm::vec3 b = frame_.At(x, z, 1.05F);
    const glm::vec3 up(0, 0, 0.5F);
    mesh_->QuadUv(a, b, b + up, a + up, board, cell.low, cell.high);
    mesh_->QuadUv(b, a, a + up, b + up, board, cell.low, cell.high);
  }

  void BuildAwning(float x0, float x1, float z) {
    static constexpr std::array<std::array<uint8_t, 3>, 5> kCloths = {
        {{190, 60, 50}, {60, 110, 80}, {60, 80, 140}, {220, 200, 150}, {150, 70, 110}}};
    const auto cloth = kCloths[static_cast<size_t>(random_->Below(5))];
    const int stripes = std::max(3, static_cast<int>((x1 - x0) / 0.5F));
    for (int i = 0; i < stripes; ++i) {
      const float a = x0 + (x1 - x0) * static_cast<float>(i) / static_cast<float>(stripes);
      const float b = x0 + (x1 - x0) * static_cast<float>(i + 1) / static_cast<float>(stripes);
      const Surface stripe = MakeSurface(Texture::kPlaster1, ClassId::kBuilding,
                                         i % 2 == 0 ? cloth : std::array<uint8_t, 3>{235, 230, 220});
      mesh_->Quad(frame_.At(a, z - 0.6F, 1.3F), frame_.At(b, z - 0.6F, 1.3F), frame_.At(b, z, 0.05F),
                  frame_.At(a, z, 0.05F), stripe);
      frame_.Rect(mesh_, a, z - 0.8F, b, z - 0.6F, 1.3F, stripe);
    }
  }

  void BuildCornice(float z) {
    frame_.Ledge(mesh_, -0.05F, z - 0.45F, frame_.width() + 0.05F, z - 0.2F, 0.18F, Trim(style_));
    frame_.Ledge(mesh_, -0.05F, z - 0.2F, frame_.width() + 0.05F, z, 0.42F, Trim(style_, 0.95));
    for (float x = 0.3F; x < frame_.width() - 0.3F; x += 0.8F) {
      frame_.Ledge(mesh_, x, z - 0.42F, x + 0.2F, z - 0.2F, 0.36F, Trim(style_, 0.9));
    }
  }

  void BuildDrainPipe(float z) {
    const float x = random_->Chance(0.5) ? 0.18F : frame_.width() - 0.18F;
    mesh_->Tube(
        frame_.At(x, 0.2F, 0.1F), frame_.At(x, z - 0.4F, 0.1F), 0.06F, 0.06F, 5,
        MakeSurface(Texture::kMetal, ClassId::kBuilding, Shade({200, 190, 175}, random_->Uniform(0.5, 1))));
  }

  void AddCut(Texture texture, float x, float z, float width, float height, const CellUv& cell) {
    const Surface surface = MakeSurface(texture, ClassId::kBuilding);
    constexpr float kOut = 0.075F;
    mesh_->CutQuad({frame_.At(x, z, kOut), frame_.At(x + width, z, kOut),
                    frame_.At(x + width, z + height, kOut), frame_.At(x, z + height, kOut)},
                   cell.low, cell.high, frame_.out(), surface);
  }

  void AddGraffiti(float z0) {
    const float width = random_->Float(1.2, 2.6);
    if (frame_.width() < width + 1) return;
    AddCut(Texture::kGraffiti, random_->Float(0.3, frame_.width() - width - 0.3), z0 + 0.2F, width,
           width * 0.6F, CellOf(random_->Below(16), 4, 4));
  }

  void AddPoster(float z0) {
    const float x = random_->Float(0.2, std::max(0.3, frame_.width() - 1.2));
    const auto texture = random_->Chance(0.5) ? Texture::kPosters0 : Texture::kPosters1;
    AddCut(texture, x, z0 + 1.0F, 0.85F, 1.3F, CellOf(random_->Below(8), 4, 2));
  }

  const HouseStyle& style_;
  const WallFrame& frame_;
  Random* random_;
  MeshBuilder* mesh_;
  int bays_ = 1;
  float bay_ = 1;
};

struct WallKind {
  Texture texture;
  std::vector<std::array<uint8_t, 3>> tints;
};

const std::vector<WallKind>& WallKinds() {
  static const std::vector<WallKind> kinds = {
      {Texture::kBrick0, {{255, 255, 255}, {230, 200, 190}, {255, 220, 200}}},
      {Texture::kBrick1, {{255, 255, 255}, {240, 225, 200}, {225, 235, 230}}},
      {Texture::kBrick2, {{255, 255, 255}, {255, 235, 230}, {210, 200, 200}}},
      {Texture::kPlaster0,
       {{255, 236, 190}, {255, 214, 176}, {250, 250, 240}, {210, 226, 214}, {200, 216, 232}}},
      {Texture::kPlaster1,
       {{236, 196, 170}, {222, 222, 222}, {206, 214, 190}, {240, 224, 170}, {226, 190, 186}}},
      {Texture::kPlaster2, {{255, 240, 214}, {230, 210, 180}, {216, 220, 226}}},
      {Texture::kPlasterBroken, {{255, 240, 220}, {230, 226, 214}}},
      {Texture::kAshlar0, {{255, 255, 255}, {240, 226, 206}}},
      {Texture::kAshlar1, {{255, 255, 255}, {236, 230, 220}}},
      {Texture::kConcrete0, {{255, 255, 255}, {226, 230, 236}}},
      {Texture::kConcrete1, {{255, 255, 255}}},
      {Texture::kPanels, {{255, 255, 255}, {196, 214, 230}, {230, 220, 200}}},
      {Texture::kTiles, {{255, 255, 255}, {206, 226, 220}, {240, 214, 190}}},
  };
  return kinds;
}

}  // namespace

HouseStyle ChooseStyle(uint64_t seed, int house) {
  Random random(seed, kStylePurpose, static_cast<uint64_t>(house));
  HouseStyle style;
  style.seed = random.Next();
  const WallKind& wall = random.Pick(WallKinds());
  style.wall = wall.texture;
  style.wall_tint = Shade(random.Pick(wall.tints), random.Uniform(0.82, 1.0));
  style.trim_tint = Shade({255, 250, 240}, random.Uniform(0.55, 1.0));
  style.windows = static_cast<Texture>(static_cast<int>(Texture::kWindows0) + random.Below(6));
  const double ground = random.Uniform();
  style.ground = ground < 0.5    ? GroundFloor::kShops
                 : ground < 0.75 ? GroundFloor::kPlinth
                                 : GroundFloor::kFlats;
  style.floors = random.Integer(2, 6);
  style.ground_height = random.Float(3.5, 4.4);
  style.floor_height = random.Float(2.9, 3.4);
  style.window_width = random.Float(1.0, 1.7);
  style.window_height = random.Float(1.3, 2.0);
  style.bay_width = style.window_width + random.Float(0.9, 1.9);
  style.balconies = random.Chance(0.3);
  style.cornice = random.Chance(0.7);
  style.bands = random.Chance(0.45);
  style.surrounds = random.Chance(0.5);
  style.awnings = random.Chance(0.5);
  style.pitched_roof = style.floors <= 4 && random.Chance(0.55);
  return style;
}

void BuildStreetFacade(const HouseStyle& style, const glm::dvec2& p, const glm::dvec2& q, float z0,
                       Random* random, MeshBuilder* mesh) {
  const WallFrame frame(p, q);
  FacadeBuilder(style, frame, random, mesh).Build(z0);
}

void BuildRearFacade(const HouseStyle& style, const glm::dvec2& p, const glm::dvec2& q, float z0,
                     Random* random, MeshBuilder* mesh) {
  const WallFrame frame(p, q);
  const float top = style.WallHeight();
  frame.Rect(mesh, 0, z0, frame.width(), top, 0, Wall(style));
  const int bays = std::max(1, static_cast<int>(frame.width() / 3.2F));
  const float bay = frame.width() / static_cast<float>(bays);
  Surface glass = MakeSurface(style.windows, ClassId::kBuilding, {230, 230, 230});
  for (float z = 1.1F; z + 1.8F < top; z += style.floor_height) {
    for (int i = 0; i < bays; ++i) {
      if (random->Chance(0.15)) continue;
      const CellUv cell = CellOf(random->Below(16), 4, 4);
      const float middle = (static_cast<float>(i) + 0.5F) * bay;
      frame.RectUv(mesh, middle - 0.55F, z, middle + 0.55F, z + 1.5F, 0.02F, glass, cell.low, cell.high);
    }
  }
}

void BuildPartyWall(const HouseStyle& style, const glm::dvec2& p, const glm::dvec2& q, float z0,
                    Random* random, MeshBuilder* mesh) {
  const WallFrame frame(p, q);
  const float top = style.WallHeight();
  Surface wall = Wall(style);
  if (random->Chance(0.5))
    wall = MakeSurface(Texture::kPlasterBroken, ClassId::kBuilding, Shade(style.wall_tint, 0.9));
  frame.Rect(mesh, 0, z0, frame.width(), top, 0, wall);
  if (top < 8 || !random->Chance(0.35)) return;
  const auto texture = random->Chance(0.5) ? Texture::kPosters0 : Texture::kPosters1;
  const CellUv cell = CellOf(random->Below(8), 4, 2);
  const float middle = frame.width() / 2;
  frame.RectUv(mesh, middle - 2.4F, top - 7.5F, middle + 2.4F, top - 0.8F, 0.02F,
               MakeSurface(texture, ClassId::kBuilding), cell.low, cell.high);
}

}  // namespace semmap::town
