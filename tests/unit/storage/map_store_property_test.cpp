// Random deltas, applied in order, lead to the map they were told from, whatever happens in between.
#include "delta_generator.h"
#include "storage_test_support.h"

namespace semmap::storage {
namespace {

class RandomDeltas : public testing::TestWithParam<uint32_t> {
 protected:
  RandomDeltas() : generator_(GetParam()), store_(OpenOrDie(ConfigFor(dir_.File("maps.db")))) {
    map_ = store_->CreateMap(MapNamed("random"))->id;
    session_ = store_->StartSession(SessionOf(map_, "random"))->id;
  }

  void ExpectKeyFrames(const ModelMap& model) {
    const std::vector<KeyFrameEntry> stored = AllKeyFrames(*store_, map_, {.with_features = true});
    ASSERT_EQ(stored.size(), model.keyframes.size());
    auto expected = model.keyframes.begin();
    for (const KeyFrameEntry& entry : stored) {
      const KeyFrameRecord& record = (expected++)->second;
      ASSERT_EQ(entry.record.id, record.id);
      EXPECT_EQ(entry.record.sequence, record.sequence);
      EXPECT_EQ(entry.record.timestamp, record.timestamp);
      EXPECT_EQ(entry.record.parent, record.parent);
      EXPECT_TRUE(SamePose(entry.record.map_from_camera, record.map_from_camera));
      EXPECT_TRUE(SameFeatures(*entry.record.features, *record.features));
      EXPECT_EQ(store_->GetObservations(map_, record.id)->point_of_keypoint,
                model.observations.at(record.id.value()));
    }
  }

  void ExpectPoints(const ModelMap& model) {
    const std::vector<MapPointRecord> stored = AllPoints(*store_, map_);
    ASSERT_EQ(stored.size(), model.points.size());
    auto expected = model.points.begin();
    for (const MapPointRecord& point : stored) EXPECT_TRUE(SamePoint(point, (expected++)->second));
  }

  void ExpectTrajectory(const ModelMap& model) {
    const std::vector<TrajectoryPose> stored = Trajectory(*store_, map_);
    ASSERT_EQ(stored.size(), model.frames.size());
    auto expected = model.frames.begin();
    for (const TrajectoryPose& pose : stored) {
      const FramePose& frame = (expected++)->second;
      ASSERT_EQ(pose.sequence, frame.sequence);
      EXPECT_EQ(pose.timestamp, frame.timestamp);
      ASSERT_EQ(pose.reference_keyframe, frame.reference_keyframe);
      EXPECT_TRUE(SamePose(
          pose.map_from_camera,
          model.keyframes.at(frame.reference_keyframe.value()).map_from_camera * frame.keyframe_from_camera));
    }
  }

  // Every box query answers as a scan of the model would.
  void ExpectBoxes(const ModelMap& model, std::mt19937* random) {
    std::uniform_real_distribution<double> corner(-40, 30);
    std::uniform_real_distribution<double> edge(0, 30);
    for (int i = 0; i < 10; ++i) {
      const Eigen::Vector3d low(corner(*random), corner(*random), corner(*random));
      const Eigen::AlignedBox3d box(low, low + Eigen::Vector3d(edge(*random), edge(*random), edge(*random)));
      std::vector<uint64_t> points;
      for (const auto& [id, point] : model.points) {
        if (box.contains(point.position_in_map)) points.push_back(id);
      }
      std::vector<uint64_t> keyframes;
      for (const auto& [id, keyframe] : model.keyframes) {
        if (box.contains(keyframe.map_from_camera.translation())) keyframes.push_back(id);
      }
      EXPECT_EQ(PointIds(*store_, map_, {.box = box}), points);
      EXPECT_EQ(KeyFrameIds(*store_, map_, {.box = box}), keyframes);
    }
  }

  void ExpectModel(std::mt19937* random) {
    const ModelMap& model = generator_.model();
    ExpectKeyFrames(model);
    ExpectPoints(model);
    ExpectTrajectory(model);
    ExpectBoxes(model, random);
    const absl::StatusOr<MapInfo> map = store_->GetMap(map_);
    EXPECT_EQ(map->keyframe_count, model.keyframes.size());
    EXPECT_EQ(map->point_count, model.points.size());
    EXPECT_EQ(store_->GetSession(map_, session_)->stored_frames, model.frames.size());
    EXPECT_EQ(Findings(*store_, map_), "");
  }

  TempDir dir_;
  DeltaGenerator generator_;
  std::unique_ptr<MapStore> store_;
  MapId map_;
  SessionId session_;
};

TEST_P(RandomDeltas, LeadToTheModel) {
  std::mt19937 random(GetParam());
  for (int step = 1; step <= 120; ++step) {
    const absl::Status status = store_->Apply(map_, session_, generator_.Next());
    ASSERT_TRUE(status.ok()) << "step " << step << ": " << status;
    if (step % 30 != 0) continue;
    SCOPED_TRACE(step);
    ExpectModel(&random);
    store_.reset();
    store_ = OpenOrDie(ConfigFor(dir_.File("maps.db")));
    ExpectModel(&random);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomDeltas, testing::Range(uint32_t{1}, uint32_t{11}));

}  // namespace
}  // namespace semmap::storage
