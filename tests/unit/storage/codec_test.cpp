#include <cmath>
#include <random>

#include "storage/appearance_codec.h"
#include "storage/feature_codec.h"
#include "storage/geometry_codec.h"
#include "storage/observation_codec.h"
#include "storage_test_support.h"

namespace semmap::storage {
namespace {

Blob Encoded(const FrameFeatures& features) {
  ByteWriter out;
  EncodeFeatures(features, &out);
  return out.Take();
}

FrameFeatures RandomFeatures(size_t count, uint32_t seed, bool with_depth, bool with_classes) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> real(0, 1000);
  FrameFeatures features;
  for (size_t i = 0; i < count; ++i) {
    const bool deep = with_depth && random() % 2 == 0;
    features.keypoints.push_back(
        {real(random), real(random), deep ? real(random) : -1.0F, deep ? real(random) : -1.0F, real(random),
         static_cast<uint8_t>(random() % 8), static_cast<uint8_t>(with_classes ? random() % 23 : 255)});
    features.descriptors.push_back({{random(), random(), random(), random()}});
  }
  return features;
}

TEST(FeatureCodec, RoundTripIsExact) {
  for (const size_t count : {0, 1, 7, 8, 9, 2000}) {
    for (const bool with_depth : {false, true}) {
      const FrameFeatures features = RandomFeatures(count, 3, with_depth, !with_depth);
      const absl::StatusOr<FrameFeatures> decoded = DecodeFeatures(Encoded(features));
      ASSERT_TRUE(decoded.ok()) << decoded.status();
      EXPECT_TRUE(SameFeatures(features, *decoded)) << count;
    }
  }
}

TEST(FeatureCodec, KeepsSignOfZeroAndOddFloats) {
  FrameFeatures features = RandomFeatures(40, 4, true, true);
  features.keypoints[0].x = -0.0F;
  features.keypoints[1].x = 0.0F;
  features.keypoints[2].right_x = std::nextafter(-1.0F, 0.0F);
  features.keypoints[3].depth = std::numeric_limits<float>::denorm_min();
  for (size_t i = 4; i < 40; ++i) features.keypoints[i].angle = 0.0F;  // a sparse column
  features.keypoints[0].angle = -0.0F;
  const absl::StatusOr<FrameFeatures> decoded = DecodeFeatures(Encoded(features));
  ASSERT_TRUE(decoded.ok());
  EXPECT_TRUE(SameFeatures(features, *decoded));
}

TEST(FeatureCodec, AbsentDepthAndClassesCostNothing) {
  constexpr size_t kCount = 2000;
  const size_t mono = Encoded(RandomFeatures(kCount, 5, false, false)).size();
  // x, y, angle, octave and the descriptor, and a few bytes for each column.
  EXPECT_LE(mono, kCount * (4 + 4 + 4 + 1 + 32) + 64);
  const size_t stereo = Encoded(RandomFeatures(kCount, 5, true, false)).size();
  // Half of them have no depth.
  EXPECT_LE(stereo, mono + kCount * 9 / 2);
}

// Whatever bytes come, a decoder answers: a value or DATA_LOSS.
template <typename Decode>
void ExpectSurvivesDamage(const Blob& good, Decode&& decode) {
  for (size_t size = 0; size < good.size(); ++size) {
    EXPECT_TRUE(absl::IsDataLoss(decode(BlobView(good).first(size)))) << "cut to " << size;
  }
  Blob longer = good;
  longer.push_back(0);
  EXPECT_TRUE(absl::IsDataLoss(decode(longer)));
  std::mt19937 random(11);
  for (int i = 0; i < 3000; ++i) {
    Blob damaged = good;
    for (size_t k = 0; k <= random() % 4; ++k)
      damaged[random() % damaged.size()] = static_cast<uint8_t>(random());
    const absl::Status status = decode(damaged);
    EXPECT_TRUE(status.ok() || absl::IsDataLoss(status)) << status;
  }
}

TEST(FeatureCodec, SurvivesDamage) {
  ExpectSurvivesDamage(Encoded(RandomFeatures(20, 6, true, true)),
                       [](BlobView bytes) { return DecodeFeatures(bytes).status(); });
}

TEST(FeatureCodec, RefusesHugeCountWithoutAllocating) {
  ByteWriter out;
  out.Put<uint8_t>(1);
  out.Put<uint32_t>(0xFFFFFFFF);
  EXPECT_TRUE(absl::IsDataLoss(DecodeFeatures(out.view()).status()));
}

TEST(ObservationCodec, RoundTripAndSize) {
  std::mt19937 random(8);
  std::vector<MapPointId> points(2000);
  uint32_t seen = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    if (random() % 3 != 0) continue;
    points[i] = MapPointId(500000 + random() % 4000);
    ++seen;
  }
  ByteWriter out;
  EXPECT_EQ(EncodeObservations(points, &out), seen);
  EXPECT_LE(out.view().size(), 8 + 4 * seen);
  const absl::StatusOr<std::vector<MapPointId>> decoded = DecodeObservations(out.view());
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(*decoded, points);
}

TEST(ObservationCodec, ExtremeIdsAndEdges) {
  for (const std::vector<MapPointId>& points : {std::vector<MapPointId>{},
                                                std::vector<MapPointId>(5),
                                                {MapPointId((uint64_t{1} << 40) - 1), MapPointId(1)},
                                                {MapPointId(), MapPointId(), MapPointId(9)}}) {
    ByteWriter out;
    EncodeObservations(points, &out);
    const absl::StatusOr<std::vector<MapPointId>> decoded = DecodeObservations(out.view());
    ASSERT_TRUE(decoded.ok());
    EXPECT_EQ(*decoded, points);
  }
}

TEST(ObservationCodec, SurvivesDamage) {
  std::vector<MapPointId> points(50);
  for (size_t i = 0; i < points.size(); i += 3) points[i] = MapPointId(1000 - i);
  ByteWriter out;
  EncodeObservations(points, &out);
  ExpectSurvivesDamage(out.Take(), [](BlobView bytes) { return DecodeObservations(bytes).status(); });
}

TEST(AppearanceCodec, RoundTripAndDamage) {
  MapPointRecord point = PointAt(5, {1, 2, 3});
  point.votes = {{0, 1}, {255, 4000000000}, {7, 128}};
  ByteWriter out;
  EncodeAppearance(point, &out);
  MapPointRecord decoded = point;
  decoded.votes.clear();
  decoded.normal.setZero();
  decoded.descriptor = Descriptor();
  ASSERT_TRUE(DecodeAppearance(out.view(), &decoded).ok());
  EXPECT_TRUE(SamePoint(point, decoded));
  ExpectSurvivesDamage(out.Take(), [](BlobView bytes) {
    MapPointRecord ignored;
    return DecodeAppearance(bytes, &ignored);
  });
}

TEST(GeometryCodec, PoseRoundTripIsExact) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal(0, 100);
  for (int i = 0; i < 1000; ++i) {
    const SE3 pose(Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)),
                   {normal(random), -0.0, normal(random)});
    const absl::StatusOr<SE3> decoded = DecodePose(EncodePose(pose));
    ASSERT_TRUE(decoded.ok());
    EXPECT_TRUE(SamePose(pose, *decoded));
  }
}

TEST(GeometryCodec, RefusesPosesNobodyStored) {
  auto bytes = EncodePose(SE3());
  EXPECT_TRUE(absl::IsDataLoss(DecodePose(BlobView(bytes).first(55)).status()));
  bytes[55] = 0x7F;  // of the exponent of w
  EXPECT_TRUE(absl::IsDataLoss(DecodePose(bytes).status()));
}

TEST(GeometryCodec, RigRoundTripAndDamage) {
  CameraRig rig = StereoRig();
  rig.sensor = SensorType::kRgbd;
  rig.camera.distortion_model = DistortionModel::kEquidistant;
  rig.camera.distortion = {0.1, -0.2, 0.3, -0.4, 0};
  rig.depth_units_per_metre = 5000;
  rig.frames_per_second = 29.97;
  const Blob bytes = EncodeRig(rig);
  const absl::StatusOr<CameraRig> decoded = DecodeRig(bytes);
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(EncodeRig(*decoded), bytes);
  EXPECT_EQ(decoded->sensor, rig.sensor);
  EXPECT_EQ(decoded->camera.distortion, rig.camera.distortion);
  EXPECT_EQ(decoded->camera.height, 376);
  EXPECT_EQ(decoded->baseline_m, 0.537);
  EXPECT_EQ(decoded->depth_units_per_metre, 5000);
  EXPECT_EQ(decoded->frames_per_second, 29.97);
  EXPECT_TRUE(SamePose(decoded->body_from_camera, rig.body_from_camera));
  ExpectSurvivesDamage(bytes, [](BlobView blob) { return DecodeRig(blob).status(); });
}

TEST(GeometryCodec, Sim3RoundTripAndDamage) {
  const Sim3 transform{3.7, SE3(Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {10, -20, 0.1})};
  const Blob bytes = EncodeSim3(transform);
  const absl::StatusOr<Sim3> decoded = DecodeSim3(bytes);
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(decoded->scale, 3.7);
  EXPECT_TRUE(SamePose(decoded->rigid, transform.rigid));
  ExpectSurvivesDamage(bytes, [](BlobView blob) { return DecodeSim3(blob).status(); });
}

}  // namespace
}  // namespace semmap::storage
