// A vehicle that extends a map which does not show yet where it begins.
#include "slam/pipeline/own_piece.h"

#include <algorithm>
#include <map>

#include "tests/unit/pipeline/stored_map_fixture.h"

namespace semmap {
namespace {

using namespace testing;  // NOLINT: room, and what is made of it

constexpr int kAway = 180;  // degrees; the map of the room shows nothing of what is behind
constexpr int kDegreesPerFrame = 4;

class OwnPieceTest : public StoredMapTest {
 protected:
  OwnPieceTest() : sink_(MakeCollector()) {
    map_ = std::make_shared<SharedMap>(*made_->Restore(), made_->last_keyframe());
  }

  // Turns from one side to the other; the answers.
  static std::vector<FrameResult> Turn(Session* session, int from, int to) {
    std::vector<FrameResult> results;
    const int steps = std::abs(to - from) / kDegreesPerFrame;
    for (int i = 0; i <= steps; ++i) {
      const auto result = session->Track(SeeRoom(SmallRig(SensorType::kStereo), At(from, to, i), i));
      EXPECT_TRUE(result.ok()) << result.status();
      results.push_back(*result);
    }
    return results;
  }
  static SE3 At(int from, int to, int i) {
    return LookAround(from + (to > from ? kDegreesPerFrame : -kDegreesPerFrame) * i);
  }

  // Where the session's frames are in the end, by the deltas of all; ascending.
  std::map<uint64_t, SE3> Trajectory() const {
    std::map<uint64_t, SE3> poses;
    for (const MapDelta& delta : sink_.deltas()) {
      for (const FramePose& frame : delta.frames) {
        const auto keyframe = sink_.keyframes().find(frame.reference_keyframe);
        if (keyframe == sink_.keyframes().end()) continue;  // culled later
        EXPECT_TRUE(
            poses.emplace(frame.sequence, keyframe->second.map_from_camera * frame.keyframe_from_camera)
                .second)
            << "frame " << frame.sequence << " is there twice";
      }
    }
    return poses;
  }

  // Before the session: what it extends.
  void StoreMap() {
    for (const MapDelta& delta : made_->deltas()) {
      MapDelta alone = delta;
      alone.frames.clear();
      sink_.OnDelta(std::move(alone));
    }
  }

  MapCollector sink_;
  std::shared_ptr<SharedMap> map_;
};

TEST_F(OwnPieceTest, BecomesPartOfTheMapWhenAPlaceIsRecognized) {
  StoreMap();
  const auto session = Extender(map_, &sink_);
  const std::vector<FrameResult> results = Turn(session.get(), kAway, 0);
  session->Finish();
  EXPECT_EQ(session->Stats().joined_pieces, 1);

  // At first it knows itself in its own frame, then in the map's.
  EXPECT_TRUE(results.front().in_own_piece);
  EXPECT_FALSE(results.back().in_own_piece);
  ExpectAt(results.back(), LookAround(0), kBound);
  const auto found = std::find_if(results.begin(), results.end(),
                                  [](const FrameResult& result) { return !result.in_own_piece; });
  EXPECT_TRUE(
      std::none_of(found, results.end(), [](const FrameResult& result) { return result.in_own_piece; }));
  EXPECT_GT(found - results.begin(), 10);
  for (const FrameResult& result : results)
    EXPECT_EQ(result.state, TrackingState::kTracking) << result.sequence;

  // The stored trajectory has the piece's frames as well, in the map's frame.
  const std::map<uint64_t, SE3> trajectory = Trajectory();
  EXPECT_GE(trajectory.size(), results.size() * 3 / 4);
  EXPECT_LE(trajectory.begin()->first, 2U);
  for (const auto& [sequence, map_from_camera] : trajectory) {
    const SE3 error =
        map_from_camera.Inverse() * MapFromWorld() * At(kAway, 0, static_cast<int>(sequence) - 1);
    EXPECT_LT(error.translation().norm(), 2 * kBound) << sequence;
    EXPECT_LT(error.RotationAngle(), 0.02) << sequence;
  }
  const auto whole = sink_.Restore();
  ASSERT_TRUE(whole.ok()) << whole.status();
  EXPECT_EQ(static_cast<int>(whole->keyframes().size()), session->Stats().keyframes);
  EXPECT_EQ(static_cast<int>(whole->points().size()), session->Stats().points);
}

TEST_F(OwnPieceTest, IsTriedAgainAsTheMapGrowsAroundTheVehicle) {
  StoreMap();
  const auto session = Extender(map_, &sink_);
  Turn(session.get(), kAway, -60);
  EXPECT_EQ(session->Stats().joined_pieces, 1);
}

TEST_F(OwnPieceTest, ACorrectionTiesWhatWasReportedToTheMap) {
  StoreMap();
  const auto session = Extender(map_, &sink_);
  const std::vector<FrameResult> results = Turn(session.get(), kAway, 0);
  session->Finish();
  const auto& deltas = sink_.deltas();
  const auto joined = std::find_if(deltas.rbegin(), deltas.rend(),
                                   [](const MapDelta& delta) { return !delta.corrections.empty(); });
  ASSERT_NE(joined, deltas.rend());
  int tied = 0;
  for (const PoseCorrection& correction : joined->corrections) {
    for (const FrameResult& result : results) {
      if (!result.in_own_piece || result.sequence < correction.from_sequence ||
          result.sequence > correction.through_sequence) {
        continue;
      }
      const Eigen::Vector3d corrected =
          correction.corrected_from_reported * result.map_from_camera->translation();
      const SE3 truth = MapFromWorld() * At(kAway, 0, static_cast<int>(result.sequence) - 1);
      EXPECT_LT((corrected - truth.translation()).norm(), 2 * kBound) << result.sequence;
      ++tied;
    }
  }
  EXPECT_GT(tied, 10);
}

// Nothing of it counts as durable before it is part of the map.
TEST_F(OwnPieceTest, ItsFramesWaitUntilItIsJoined) {
  StoreMap();
  const size_t before = sink_.deltas().size();
  const auto session = Extender(map_, &sink_);
  Turn(session.get(), kAway, 0);
  session->Finish();
  bool was_joined = false;
  for (size_t i = before; i < sink_.deltas().size(); ++i) {
    const MapDelta& delta = sink_.deltas()[i];
    was_joined = was_joined || std::any_of(delta.added_keyframes.begin(), delta.added_keyframes.end(),
                                           [](const KeyFrameRecord& added) { return added.sequence == 1; });
    EXPECT_EQ(delta.waiting_from, was_joined ? 0U : 1U) << i;
  }
  EXPECT_TRUE(was_joined);
}

TEST_F(OwnPieceTest, IsDroppedWhenItShowsNoPlaceOfTheMap) {
  const auto session = Extender(map_, &sink_);
  const std::vector<FrameResult> results = Turn(session.get(), kAway, 100);
  const int before = session->Stats().keyframes;
  session->Finish();
  EXPECT_EQ(session->Stats().joined_pieces, 0);
  EXPECT_EQ(session->Stats().keyframes, before);
  EXPECT_EQ(before, static_cast<int>(made_->keyframes().size()));
  EXPECT_TRUE(sink_.deltas().empty());
  EXPECT_TRUE(std::all_of(results.begin(), results.end(),
                          [](const FrameResult& result) { return result.in_own_piece; }));
}

// What both show was mapped by the other vehicle after this one had been there.
TEST_F(OwnPieceTest, IsJoinedAtTheEndWhenTheMapHasComeToItMeanwhile) {
  StoreMap();
  const auto session = Extender(map_, &sink_);
  Turn(session.get(), kAway, 80);
  MapCollector others = MakeCollector();
  const auto other = Extender(map_, &others);
  EXPECT_FALSE(Turn(other.get(), 0, 140).back().in_own_piece);
  other->Finish();
  EXPECT_EQ(session->Stats().joined_pieces, 0);
  session->Finish();
  EXPECT_EQ(session->Stats().joined_pieces, 1);
}

}  // namespace
}  // namespace semmap
