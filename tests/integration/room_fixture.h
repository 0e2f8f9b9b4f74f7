#pragma once

#include <algorithm>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/image.h"
#include "service_fixture.h"
#include "slam/place/vocabulary.h"
#include "tests/support/textured_room.h"

namespace semmap {

// Metres between pictures.
constexpr double kStep = 0.12;

struct Picture {
  v1::Image image;
  v1::Image right;
};

inline v1::CameraRig RoomRig(v1::SensorType sensor) {
  const CameraRig rig = testing::SmallRig(SensorType::kStereo);
  v1::CameraRig proto;
  proto.set_sensor(sensor);
  v1::CameraIntrinsics* camera = proto.mutable_camera();
  camera->set_width(rig.camera.width);
  camera->set_height(rig.camera.height);
  camera->set_fx(rig.camera.fx);
  camera->set_fy(rig.camera.fy);
  camera->set_cx(rig.camera.cx);
  camera->set_cy(rig.camera.cy);
  camera->set_distortion_model(v1::DISTORTION_MODEL_NONE);
  if (sensor == v1::SENSOR_TYPE_STEREO) proto.set_baseline_m(rig.baseline_m);
  return proto;
}

// Pictures along a gentle drive through a room; drawn when they are first asked for. Thread-safe.
class RoomPictures {
 public:
  explicit RoomPictures(uint32_t room) : room_(room) {}

  const Picture& operator[](int index) {
    MutexLock lock(&mutex_);
    const CameraRig rig = testing::SmallRig(SensorType::kStereo);
    const SE3 left_from_right(Eigen::Quaterniond::Identity(), {rig.baseline_m, 0, 0});
    const auto poses = testing::GentleDrive(index + 1, kStep);
    for (size_t i = drawn_.size(); i < poses.size(); ++i) {
      drawn_.push_back({client::RawImage(room_.Render(rig.camera, poses[i])).value(),
                        client::RawImage(room_.Render(rig.camera, poses[i] * left_from_right)).value()});
    }
    return drawn_[static_cast<size_t>(index)];
  }

 private:
  const testing::TexturedRoom room_;
  Mutex mutex_;                // guards the pictures
  std::deque<Picture> drawn_;  // that stay where they are
};

// Of one room, once for all tests.
inline RoomPictures& PicturesOf(uint32_t room) {
  static Mutex mutex;
  static std::map<uint32_t, RoomPictures> rooms;
  MutexLock lock(&mutex);
  return rooms.try_emplace(room, room).first->second;
}
constexpr uint32_t kRoom = 3;

inline v1::Frame FrameOf(int picture, uint64_t sequence, bool stereo, uint32_t room = kRoom) {
  v1::Frame frame;
  frame.set_sequence(sequence);
  frame.set_timestamp_ns(static_cast<int64_t>(sequence) * 100'000'000);
  *frame.mutable_image() = PicturesOf(room)[picture].image;
  if (stereo) *frame.mutable_right() = PicturesOf(room)[picture].right;
  return frame;
}

// What the stereo rig sees elsewhere in the room of seed kRoom.
inline v1::Frame FrameAt(const SE3& world_from_camera, uint64_t sequence) {
  const CameraRig rig = testing::SmallRig(SensorType::kStereo);
  const SE3 left_from_right(Eigen::Quaterniond::Identity(), {rig.baseline_m, 0, 0});
  const testing::TexturedRoom room(kRoom);
  v1::Frame frame;
  frame.set_sequence(sequence);
  frame.set_timestamp_ns(static_cast<int64_t>(sequence) * 100'000'000);
  *frame.mutable_image() = client::RawImage(room.Render(rig.camera, world_from_camera)).value();
  *frame.mutable_right() =
      client::RawImage(room.Render(rig.camera, world_from_camera * left_from_right)).value();
  return frame;
}

// A server with real SLAM, and drives through rooms.
class RoomTest : public ServiceTest {
 protected:
  void StartRealServer() {
    server_.reset();
    config_.slam.orb.features = 800;
    const auto vocabulary = LoadVocabulary(config_.slam.place);
    ASSERT_TRUE(vocabulary.ok()) << vocabulary.status();
    auto server = server::Server::Start(
        config_,
        [vocabulary = *vocabulary](const SlamConfig& config, const CameraRig& rig, MapDeltaSink* sink,
                                   Executor* executor, SessionStart start) {
          return Session::Create(config, rig, sink, executor, vocabulary, nullptr, std::move(start));
        },
        *vocabulary);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
  }

  client::DriveOptions OptionsFor(v1::SessionMode mode, const std::string& map, bool stereo = true) const {
    client::DriveOptions options = DriveTo(map);
    options.mode = mode;
    options.rig = RoomRig(stereo ? v1::SENSOR_TYPE_STEREO : v1::SENSOR_TYPE_MONO);
    return options;
  }

  // Drives along pictures [begin, end); how many were tracked. Answers go to recorder_.
  int Drive(v1::SessionMode mode, const std::string& map, int begin, int end, bool stereo = true,
            uint32_t room = kRoom) {
    recorder_ = std::make_unique<Recorder>();
    auto drive = client::Drive::Start(Connect(), OptionsFor(mode, map, stereo), recorder_->Observer());
    EXPECT_TRUE(drive.ok()) << drive.status();
    if (!drive.ok()) return 0;
    uint64_t sequence = 0;
    for (int i = begin; i < end; ++i) EXPECT_TRUE((*drive)->Send(FrameOf(i, ++sequence, stereo, room)).ok());
    const auto summary = (*drive)->Finish();
    EXPECT_TRUE(summary.ok()) << summary.status();
    if (!summary.ok()) return 0;
    session_ = summary->session();
    return static_cast<int>(session_.statistics().frames_tracked());
  }

  static v1::RelocalizeRequest RequestFor(const std::string& map, int picture, bool stereo) {
    v1::RelocalizeRequest request;
    request.set_map(map);
    *request.mutable_rig() = RoomRig(stereo ? v1::SENSOR_TYPE_STEREO : v1::SENSOR_TYPE_MONO);
    *request.mutable_frame() = FrameOf(picture, 0, stereo);
    return request;
  }
  absl::StatusOr<v1::RelocalizeResponse> Relocalize(const std::string& map, int picture, bool stereo) {
    return client::Client(Connect()).Relocalize(RequestFor(map, picture, stereo));
  }

  // Where picture `second` was taken, seen from where `first` was.
  static SE3 FirstFromSecond(int first, int second) {
    const auto poses = testing::GentleDrive(std::max(first, second) + 1, kStep);
    return poses[static_cast<size_t>(first)].Inverse() * poses[static_cast<size_t>(second)];
  }

  // How far a pose in a map that begins with picture `first` is from where the picture was taken.
  static double Error(const v1::Pose& map_from_camera, int picture, int first = 0) {
    const v1::Vector3& t = map_from_camera.translation();
    return (Eigen::Vector3d(t.x(), t.y(), t.z()) - FirstFromSecond(first, picture).translation()).norm();
  }

  void ExpectSound(const std::string& map) {
    const auto check = client::Client(Connect()).CheckMap(map, nullptr);
    ASSERT_TRUE(check.ok()) << check.status();
    EXPECT_EQ(check->problems_size(), 0) << check->DebugString();
  }

  // By two pictures that were taken there together, in a map that begins with picture 0.
  void ExpectFound(const std::string& map, int picture) {
    const auto response = Relocalize(map, picture, true);
    ASSERT_TRUE(response.ok()) << response.status();
    ASSERT_EQ(response->result(), v1::RELOCALIZE_RESULT_FOUND) << picture;
    EXPECT_LT(Error(response->map_from_camera(), picture), kBound) << picture;
  }

  // Of a pose against the truth, metres: the map's own error, and a little.
  static constexpr double kBound = 0.06;

  std::unique_ptr<Recorder> recorder_;
  v1::Session session_;
};

}  // namespace semmap
