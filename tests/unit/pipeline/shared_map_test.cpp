// Several vehicles that extend one stored map at once.
#include "slam/pipeline/shared_map.h"

#include <algorithm>
#include <set>
#include <thread>

#include "tests/unit/pipeline/loop_test_util.h"
#include "tests/unit/pipeline/stored_map_fixture.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: room and ring, and what is made of them

constexpr int kFarFrames = kMapFrames + 16;

// The deltas of one session, and, as a store would, those of all sessions in one map.
class SessionSink : public MapDeltaSink {
 public:
  explicit SessionSink(MapCollector* all) : all_(all) {}

  void OnDelta(MapDelta delta) override {
    if (!delta.empty()) all_->OnDelta(delta);
    deltas_.push_back(std::move(delta));
  }
  const std::vector<MapDelta>& deltas() const { return deltas_; }

  std::set<KeyFrameId> AddedKeyFrames() const {
    std::set<KeyFrameId> ids;
    for (const MapDelta& delta : deltas_)
      for (const KeyFrameRecord& keyframe : delta.added_keyframes) ids.insert(keyframe.id);
    return ids;
  }

 private:
  MapCollector* const all_;
  std::vector<MapDelta> deltas_;
};

class SharedMapTest : public StoredMapTest {
 protected:
  SharedMapTest() : all_(*made_), first_sink_(&all_), second_sink_(&all_) {
    map_ = std::make_shared<SharedMap>(*made_->Restore(), made_->last_keyframe());
  }

  // From frame `begin` on, a little beside the lane of the map; how many frames were tracked.
  static int Drive(Session* session, size_t begin, size_t end, int index = 0) {
    const std::vector<SE3> poses = GentleDrive(kFarFrames, kStep);
    for (size_t i = begin; i < end; ++i) {
      session->WaitForMapper(0);
      const auto result = session->Track(SeeRoom(SmallRig(SensorType::kStereo), Beside(poses[i]), index++));
      EXPECT_TRUE(result.ok()) << result.status();
    }
    return static_cast<int>(session->Stats().tracked_frames);
  }

  // What the sessions told together is what the map is.
  void ExpectOneSoundMap(const Session& session) {
    const auto whole = all_.Restore();
    ASSERT_TRUE(whole.ok()) << whole.status();
    EXPECT_EQ(static_cast<int>(whole->keyframes().size()), session.Stats().keyframes);
    EXPECT_EQ(static_cast<int>(whole->points().size()), session.Stats().points);
  }

  MapCollector all_;
  SessionSink first_sink_;
  SessionSink second_sink_;
  std::shared_ptr<SharedMap> map_;
};

TEST_F(SharedMapTest, OneVehicleDrivesInWhatTheOtherAdded) {
  const auto first = Extender(map_, &first_sink_);
  const auto second = Extender(map_, &second_sink_);
  EXPECT_GE(Drive(first.get(), 8, kFarFrames), kFarFrames - 8 - 1);
  ASSERT_FALSE(first_sink_.AddedKeyFrames().empty());
  // It begins where only the other one has been.
  EXPECT_GE(Drive(second.get(), kMapFrames + 4, kFarFrames), kFarFrames - kMapFrames - 4 - 1);
  first->Finish();
  second->Finish();
  EXPECT_EQ(second->Stats().recoveries, 1);
  // Its frames hang on keyframes that the other one made.
  const std::set<KeyFrameId> of_first = first_sink_.AddedKeyFrames();
  int in_what_first_added = 0;
  for (const MapDelta& delta : second_sink_.deltas()) {
    for (const FramePose& frame : delta.frames)
      in_what_first_added += of_first.contains(frame.reference_keyframe) ? 1 : 0;
  }
  EXPECT_GE(in_what_first_added, 3);
  ExpectOneSoundMap(*second);
}

TEST_F(SharedMapTest, TwoVehiclesTakeTurns) {
  const auto first = Extender(map_, &first_sink_);
  const auto second = Extender(map_, &second_sink_);
  constexpr size_t kStride = 3;
  for (size_t i = 4; i + kStride < kFarFrames; i += kStride) {
    Drive(first.get(), i, i + kStride, static_cast<int>(i));
    Drive(second.get(), kFarFrames - i - kStride, kFarFrames - i, static_cast<int>(i));
  }
  first->Finish();
  second->Finish();
  std::set<KeyFrameId> own = first_sink_.AddedKeyFrames();
  for (const KeyFrameId id : second_sink_.AddedKeyFrames()) EXPECT_TRUE(own.insert(id).second) << id.value();
  for (const KeyFrameId id : own) EXPECT_GT(id, made_->last_keyframe());
  for (const SessionSink* sink : {&first_sink_, &second_sink_}) {
    uint64_t version = 0;
    for (const MapDelta& delta : sink->deltas()) EXPECT_EQ(delta.version, ++version);
  }
  ExpectOneSoundMap(*first);
}

TEST_F(SharedMapTest, TwoVehiclesDriveAtOnce) {
  const auto executor = MakeThreadPool(2);
  const auto first = Extender(map_, &first_sink_, executor.get());
  const auto second = Extender(map_, &second_sink_, executor.get());
  int tracked_by_first = 0;
  std::thread other([&] { tracked_by_first = Drive(first.get(), 4, kFarFrames); });
  const int tracked_by_second = Drive(second.get(), 10, kFarFrames);
  other.join();
  EXPECT_GE(tracked_by_first, kFarFrames - 4 - 2);
  EXPECT_GE(tracked_by_second, kFarFrames - 10 - 2);
  first->Finish();
  second->Finish();
  ExpectOneSoundMap(*first);
}

TEST_F(SharedMapTest, WhoLeavesInTheMiddleLeavesASoundMap) {
  const auto executor = MakeThreadPool(2);
  auto first = Extender(map_, &first_sink_, executor.get());
  const auto second = Extender(map_, &second_sink_, executor.get());
  Drive(first.get(), 8, kMapFrames + 8);
  first.reset();
  EXPECT_GE(Drive(second.get(), 8, kFarFrames), kFarFrames - 8 - 2);
  second->Finish();
  ExpectOneSoundMap(*second);
}

// --- A loop that one vehicle closes moves the map under the other

class SharedRingTest : public ::testing::Test {
 protected:
  SharedRingTest()
      : world_(1),
        camera_(RingWorld::Camera(SensorType::kStereo)),
        all_(RingWorld::ScaleInfo(), camera_.bounds),
        first_sink_(&all_),
        second_sink_(&all_) {}

  TrackedFrame See(int step, uint64_t sequence) const {
    const RingView view =
        world_.View(camera_, RingWorld::WorldFromCamera(step * kRingStep), static_cast<uint32_t>(sequence));
    TrackedFrame frame;
    frame.sequence = sequence;
    frame.features = std::make_shared<FrameFeatures>(view.features);
    frame.grid = std::make_shared<FeatureGrid>(camera_.bounds, view.features.keypoints);
    return frame;
  }

  // A keyframe one step behind `reference`, matched against the points around that.
  TrackOutput KeyFrameAfter(const LocalMapView& view, KeyFrameId reference, int step, uint64_t sequence,
                            KeyFrameId id) const {
    const TrackedFrame frame = See(step, sequence);
    KeyFrameCandidate candidate;
    candidate.id = id;
    candidate.sequence = sequence;
    candidate.timestamp = FromSeconds(static_cast<double>(sequence));
    candidate.features = frame.features;
    candidate.grid = frame.grid;
    candidate.reference = reference;
    candidate.camera_from_reference = RingWorld::WorldFromCamera(step * kRingStep).Inverse() *
                                      RingWorld::WorldFromCamera((step - 1) * kRingStep);
    candidate.points =
        Match(view, frame, candidate.camera_from_reference * view.FindKeyFrame(reference)->camera_from_map);
    TrackOutput output;
    output.frame_pose = FramePose{sequence, candidate.timestamp, id, SE3()};
    output.keyframe = std::move(candidate);
    return output;
  }

  std::vector<MapPointId> Match(const LocalMapView& view, const TrackedFrame& frame,
                                const SE3& camera_from_map) const {
    const ScalePyramidInfo scale_info = RingWorld::ScaleInfo();
    ProjectionSearch search;
    search.model = camera_.model;
    search.bounds = camera_.bounds;
    search.scale_info = &scale_info;
    SightingCounters counters;
    counters.visible.assign(view.size(), 0);
    ViewMatches matches(frame.features->size(), -1);
    MatchLocalMap(view, camera_from_map, {*frame.features, *frame.grid}, search, &counters, &matches);
    std::vector<MapPointId> points;
    for (const int32_t match : matches) points.push_back(match < 0 ? MapPointId() : view.ids[match]);
    return points;
  }

  RingWorld world_;
  MappingCamera camera_;
  MapCollector all_;
  SessionSink first_sink_;
  SessionSink second_sink_;
};

TEST_F(SharedRingTest, ALoopOfOneVehicleCorrectsTheOther) {
  constexpr int kStored = 48;
  Map stored = DriveRing(world_, camera_, kStored, kRingStep, RingDrift{0.004, 0});
  stored.TakeDelta();
  std::shared_ptr<const LocalMapView> view =
      MakeLocalMapView(stored, KeyFrameId(kStored), 1, LocalMapViewLimits());
  const auto queue = std::make_shared<MapperQueue>(SlamConfig(), camera_, RingWorld::ScaleInfo(),
                                                   RandomVocabulary(12, 5), nullptr);
  queue->Adopt(std::move(stored));
  MapperSeat closing(queue, &first_sink_);
  MapperSeat other(queue, &second_sink_);

  // The other vehicle is found in the middle and makes a keyframe there.
  TrackOutput lost;
  lost.lost_frame = LostFrame{See(25, 7), {}};
  other.Push(&lost);
  ASSERT_NE(other.State().view, nullptr);
  EXPECT_EQ(closing.State().view, nullptr) << "who was not found sees nothing of the map";
  const auto others_view = other.State().view;
  const KeyFrameId found_at = others_view->reference().id;
  TrackOutput own =
      KeyFrameAfter(*others_view, found_at, static_cast<int>(found_at.value()), 8, KeyFrameId(100));
  other.Push(&own);
  const auto before = other.State().view;

  KeyFrameId reference(kStored);
  for (int step = kStored; closing.counts().loops == 0 && step < kStored + 5; ++step) {
    const KeyFrameId id(static_cast<uint64_t>(101 + step));
    TrackOutput output = KeyFrameAfter(*view, reference, step, static_cast<uint64_t>(step), id);
    closing.Push(&output);
    view = closing.State().view;
    reference = id;
  }
  ASSERT_EQ(closing.counts().loops, 1);
  EXPECT_EQ(other.counts().loops, 0);

  const auto after = other.State().view;
  ASSERT_GT(after->version, before->version);
  EXPECT_EQ(after->reference().id, before->reference().id);
  const SE3 moved = before->reference().camera_from_map.Inverse() * after->reference().camera_from_map;
  EXPECT_GT(moved.translation().norm(), 0.05);
  // It hears where what it was told is now; the change itself is in the first one's delta.
  const MapDelta& news = second_sink_.deltas().back();
  EXPECT_TRUE(news.empty());
  ASSERT_EQ(news.corrections.size(), 1U);
  EXPECT_EQ(news.corrections.front().from_sequence, 8U);
  EXPECT_EQ(news.corrected_map_version, after->version);
  const SE3 expected = after->reference().camera_from_map.Inverse() * before->reference().camera_from_map;
  const SE3 difference = expected.Inverse() * news.corrections.front().corrected_from_reported.rigid;
  EXPECT_LT(difference.translation().norm(), 0.2 * moved.translation().norm() + 0.01);
}

}  // namespace
}  // namespace semmap
