#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "storage/appearance_codec.h"
#include "storage/checksum.h"
#include "storage/feature_codec.h"
#include "storage/geometry_codec.h"
#include "storage/keypoint_selection.h"
#include "storage/observation_codec.h"
#include "storage_test_support.h"

namespace semmap::storage {
namespace {

std::vector<uint32_t> AllOf(size_t count) {
  std::vector<uint32_t> indices(count);
  std::iota(indices.begin(), indices.end(), 0U);
  return indices;
}

Blob Encoded(const FrameFeatures& features) {
  ByteWriter out;
  EncodeFeatures(features, AllOf(features.size()), &out);
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

TEST(FeatureCodec, KeepsWhatMatters) {
  for (const size_t count : {0, 1, 7, 8, 9, 2000}) {
    for (const bool with_depth : {false, true}) {
      const FrameFeatures features = RandomFeatures(count, 3, with_depth, !with_depth);
      const absl::StatusOr<FrameFeatures> decoded = DecodeFeatures(Encoded(features));
      ASSERT_TRUE(decoded.ok()) << decoded.status();
      ASSERT_EQ(decoded->size(), count);
      EXPECT_EQ(decoded->descriptors, features.descriptors);
      for (size_t i = 0; i < count; ++i) {
        const Keypoint& was = features.keypoints[i];
        const Keypoint& is = decoded->keypoints[i];
        EXPECT_NEAR(is.x, was.x, 1.0 / 64);
        EXPECT_NEAR(is.y, was.y, 1.0 / 64);
        EXPECT_NEAR(is.right_x, was.right_x, 1.0 / 64);
        EXPECT_NEAR(is.depth, was.depth, was.depth < 0 ? 0 : was.depth / 4000);
        EXPECT_NEAR(std::remainder(is.angle - was.angle, 2 * std::numbers::pi), 0, std::numbers::pi / 255);
        EXPECT_GE(is.angle, 0);
        EXPECT_LT(is.angle, 2 * std::numbers::pi);
        EXPECT_EQ(is.octave, was.octave);
        EXPECT_EQ(is.semantic_class, was.semantic_class);
      }
    }
  }
}

TEST(FeatureCodec, AgainLosesNothingMore) {
  const FrameFeatures once = *DecodeFeatures(Encoded(RandomFeatures(2000, 4, true, true)));
  EXPECT_TRUE(SameFeatures(*DecodeFeatures(Encoded(once)), once));
  for (const Keypoint& keypoint : once.keypoints) EXPECT_TRUE(SameKeypoint(AsStored(keypoint), keypoint));
}

TEST(FeatureCodec, PacksTheChosenOnes) {
  const FrameFeatures features = *DecodeFeatures(Encoded(RandomFeatures(100, 4, true, true)));
  const std::vector<uint32_t> chosen = {3, 50, 99};
  ByteWriter out;
  EncodeFeatures(features, chosen, &out);
  const absl::StatusOr<FrameFeatures> decoded = DecodeFeatures(out.view());
  ASSERT_TRUE(decoded.ok());
  ASSERT_EQ(decoded->size(), chosen.size());
  for (size_t i = 0; i < chosen.size(); ++i) {
    EXPECT_TRUE(SameKeypoint(decoded->keypoints[i], features.keypoints[chosen[i]]));
    EXPECT_EQ(decoded->descriptors[i], features.descriptors[chosen[i]]);
  }
}

TEST(FeatureCodec, ExtremeNumbers) {
  FrameFeatures features = RandomFeatures(8, 4, true, true);
  features.keypoints[0].x = -30.0F;    // undistorted positions may lie outside of the image
  features.keypoints[1].x = 20000.0F;  // needs three bytes
  features.keypoints[2].x = 1e30F;
  features.keypoints[3].depth = std::numeric_limits<float>::denorm_min();
  features.keypoints[4].depth = std::numeric_limits<float>::max();
  features.keypoints[5].depth = 0;
  features.keypoints[6].angle = -0.1F;
  features.keypoints[7].right_x = -7;
  const absl::StatusOr<FrameFeatures> decoded = DecodeFeatures(Encoded(features));
  ASSERT_TRUE(decoded.ok());
  EXPECT_EQ(decoded->keypoints[0].x, -30.0F);
  EXPECT_EQ(decoded->keypoints[1].x, 20000.0F);
  EXPECT_GT(decoded->keypoints[2].x, 1e7F);
  EXPECT_TRUE(decoded->keypoints[3].HasDepth());
  EXPECT_TRUE(std::isfinite(decoded->keypoints[4].depth));
  EXPECT_FALSE(decoded->keypoints[5].HasDepth());
  EXPECT_NEAR(decoded->keypoints[6].angle, 2 * std::numbers::pi - 0.1, 0.02);
  EXPECT_EQ(decoded->keypoints[7].right_x, -1.0F);
}

TEST(FeatureCodec, AbsentDepthAndClassesCostNothing) {
  constexpr size_t kCount = 2000;
  const size_t mono = Encoded(RandomFeatures(kCount, 5, false, false)).size();
  // x, y, angle, octave and the descriptor, and a few bytes for each column.
  EXPECT_LE(mono, kCount * (2 + 2 + 1 + 1 + 32) + 64);
  const size_t stereo = Encoded(RandomFeatures(kCount, 5, true, false)).size();
  // Half of them have no depth.
  EXPECT_LE(stereo, mono + kCount * 5 / 2);
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
  ByteWriter body;
  body.PutVarint(0xFFFFFFFF);
  ByteWriter out;
  out.Put<uint8_t>(2);
  out.Put(Checksum(body.view()));
  out.PutArray(body.view());
  EXPECT_TRUE(absl::IsDataLoss(DecodeFeatures(out.view()).status()));
  ByteWriter version_one;
  version_one.Put<uint8_t>(1);
  version_one.Put<uint32_t>(0xFFFFFFFF);
  EXPECT_TRUE(absl::IsDataLoss(DecodeFeatures(version_one.view()).status()));
}

TEST(FeatureCodec, NoChangedBitGoesUnnoticed) {
  const Blob good = Encoded(RandomFeatures(20, 6, true, true));
  for (size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Blob damaged = good;
    damaged[bit / 8] = static_cast<uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_TRUE(absl::IsDataLoss(DecodeFeatures(damaged).status())) << bit;
  }
}

// --- Which keypoints are kept

TEST(KeypointSelection, FewAreKeptAll) {
  EXPECT_EQ(SelectKeypoints(5, {}, 5), AllOf(5));
  EXPECT_EQ(SelectKeypoints(0, {}, 5), AllOf(0));
}

TEST(KeypointSelection, ThoseThatSeeAPointComeFirst) {
  std::vector<MapPointId> sees(100);
  for (const size_t i : {7, 8, 90}) sees[i] = MapPointId(i);
  const std::vector<uint32_t> kept = SelectKeypoints(100, sees, 10);
  EXPECT_EQ(kept.size(), 10U);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  EXPECT_EQ(std::adjacent_find(kept.begin(), kept.end()), kept.end());
  for (const uint32_t i : {7, 8, 90}) EXPECT_TRUE(std::binary_search(kept.begin(), kept.end(), i));
  // The others lie evenly.
  for (size_t i = 1; i < kept.size(); ++i) EXPECT_LE(kept[i] - kept[i - 1], 20U);
}

TEST(KeypointSelection, AllThatSeeAPointAreKeptHoweverMany) {
  std::vector<MapPointId> sees(100, MapPointId(1));
  sees[3] = MapPointId();
  EXPECT_EQ(SelectKeypoints(100, sees, 10).size(), 99U);
}

TEST(IndexSet, RoundTripAndDamage) {
  std::mt19937 random(9);
  for (const size_t count : {1, 8, 9, 2000}) {
    for (const size_t share : {1, 2, 50}) {
      std::vector<uint32_t> indices;
      for (uint32_t i = 0; i < count; ++i) {
        if (random() % share == 0) indices.push_back(i);
      }
      const Blob packed = EncodeIndexSet(count, indices);
      EXPECT_LE(packed.size(), 14 + std::min(count / 8, indices.size() + 1));
      const absl::StatusOr<std::vector<uint32_t>> decoded = DecodeIndexSet(packed, count);
      ASSERT_TRUE(decoded.ok());
      EXPECT_EQ(*decoded, indices);
      if (packed.empty()) continue;
      EXPECT_TRUE(absl::IsDataLoss(DecodeIndexSet(packed, count + 1).status()));
    }
  }
  const Blob good = EncodeIndexSet(100, std::vector<uint32_t>{1, 7, 99});
  for (size_t bit = 0; bit < 8 * good.size(); ++bit) {
    Blob damaged = good;
    damaged[bit / 8] = static_cast<uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_TRUE(absl::IsDataLoss(DecodeIndexSet(damaged, 100).status())) << bit;
  }
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

TEST(AppearanceCodec, KeepsDirectionAndDistances) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal(0, 1);
  std::uniform_real_distribution<float> doublings(-20, 20);
  for (int i = 0; i < 10000; ++i) {
    MapPointRecord point = PointAt(5, {1, 2, 3});
    point.normal = Eigen::Vector3f(normal(random), normal(random), normal(random)).normalized();
    if (i % 10 == 0) point.normal = Eigen::Vector3i(0, i % 20 - 5, i % 30 - 15).cast<float>().normalized();
    point.min_distance = std::exp2(doublings(random));
    point.max_distance = 3.5F * point.min_distance;
    const MapPointRecord stored = AsStored(point);
    EXPECT_LT((stored.normal - point.normal).norm(), 1e-4F) << point.normal.transpose();
    EXPECT_NEAR(stored.min_distance / point.min_distance, 1, 4e-4);
    EXPECT_NEAR(stored.max_distance / point.max_distance, 1, 4e-4);
    EXPECT_TRUE(SamePoint(AsStored(stored), stored)) << point.normal.transpose();
  }
}

TEST(AppearanceCodec, KeepsThatThereIsNoDirectionOrDistance) {
  MapPointRecord point = PointAt(5, {1, 2, 3});
  point.normal.setZero();
  point.min_distance = 0;
  point.max_distance = -1;
  const MapPointRecord stored = AsStored(point);
  EXPECT_TRUE(stored.normal.isZero());
  EXPECT_EQ(stored.min_distance, 0);
  EXPECT_EQ(stored.max_distance, 0);
  point.normal.setConstant(std::numeric_limits<float>::max());
  point.max_distance = std::numeric_limits<float>::max();
  EXPECT_TRUE(AsStored(point).normal.allFinite());
  EXPECT_TRUE(std::isfinite(AsStored(point).max_distance));
}

TEST(AppearanceCodec, ReadsTheFloatsOfFormatOne) {
  const std::array<float, 5> floats = {0.6F, -0.8F, 0.0F, 1.7F, 23.4F};
  ByteWriter out;
  out.Put(uint8_t{1});
  out.PutArray(std::span<const float>(floats));
  const Descriptor descriptor{{1, 2, 3, 4}};
  out.PutArray(std::span<const uint64_t>(descriptor.words));
  out.PutVarint(1);
  out.Put(uint8_t{7});
  out.PutVarint(300);
  MapPointRecord decoded;
  ASSERT_TRUE(DecodeAppearance(out.view(), &decoded).ok());
  EXPECT_EQ(decoded.normal, Eigen::Vector3f(0.6F, -0.8F, 0.0F));
  EXPECT_EQ(decoded.min_distance, 1.7F);
  EXPECT_EQ(decoded.max_distance, 23.4F);
  EXPECT_EQ(decoded.descriptor, descriptor);
  ASSERT_EQ(decoded.votes.size(), 1U);
  EXPECT_EQ(decoded.votes.front().count, 300U);
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
