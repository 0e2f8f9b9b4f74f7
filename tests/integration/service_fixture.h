#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "client/client.h"
#include "client/connection.h"
#include "client/drive.h"
#include "client/errors.h"
#include "server/rpc/server.h"
#include "slam/common/mutex.h"
#include "tests/unit/server/fake_session.h"
#include "tests/unit/server/temporary_store.h"

namespace semmap {

// A server on a loopback port of its own with a database in a temporary directory. SLAM is a stand-in
// (FakeSession) that takes any picture, so that these tests are about the service.
class ServiceTest : public testing::Test {
 protected:
  ServiceTest() {
    config_.server.listen = "127.0.0.1:0";
    config_.server.credit_window = 4;
    config_.server.drain_timeout_s = 20;
    config_.storage.uri = directory_.database_uri();
    config_.server.artifact_directory = directory_.path() + "/artifacts";
  }
  ~ServiceTest() override { gate_.Open(); }

  void SetUp() override { StartServer(); }

  void StartServer() {
    auto server = server::Server::Start(config_, server::FakeSession::Factory(&gate_));
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = std::move(server).value();
  }

  std::shared_ptr<client::Connection> Connect() {
    client::ConnectOptions options;
    options.address = server_->address();
    options.call_timeout = std::chrono::seconds(20);
    auto connection = client::Connection::Open(options);
    EXPECT_TRUE(connection.ok()) << connection.status();
    return connection.value_or(nullptr);
  }

  static v1::CameraRig Rig(v1::SensorType sensor = v1::SENSOR_TYPE_MONO) {
    v1::CameraRig rig;
    rig.set_sensor(sensor);
    v1::CameraIntrinsics* camera = rig.mutable_camera();
    camera->set_width(64);
    camera->set_height(48);
    camera->set_fx(50);
    camera->set_fy(50);
    camera->set_cx(32);
    camera->set_cy(24);
    camera->set_distortion_model(v1::DISTORTION_MODEL_NONE);
    if (sensor == v1::SENSOR_TYPE_STEREO) rig.set_baseline_m(0.5);
    return rig;
  }

  static v1::Image GreyImage(int width = 64, int height = 48) {
    v1::Image image;
    image.set_encoding(v1::IMAGE_ENCODING_RAW_GRAY8);
    image.set_width(width);
    image.set_height(height);
    image.set_data(std::string(static_cast<size_t>(width) * static_cast<size_t>(height), '\x40'));
    return image;
  }

  // Frame s is taken at 100 s nanoseconds.
  static v1::Frame Frame(uint64_t sequence) {
    v1::Frame frame;
    frame.set_sequence(sequence);
    frame.set_timestamp_ns(static_cast<int64_t>(sequence) * 100);
    *frame.mutable_image() = GreyImage();
    return frame;
  }

  static client::DriveOptions DriveTo(const std::string& map) {
    client::DriveOptions options;
    options.vehicle_id = "car";
    options.map = map;
    options.rig = Rig();
    options.send_timeout = std::chrono::seconds(20);
    return options;
  }

  // Sequences of the frames whose poses are stored.
  std::vector<uint64_t> StoredFrames(const std::string& map) {
    std::vector<uint64_t> sequences;
    v1::GetTrajectoryRequest request;
    request.set_map(map);
    const absl::Status status =
        client::Client(Connect()).GetTrajectory(request, [&](const v1::GetTrajectoryResponse& response) {
          const auto& columns = response.trajectory();
          sequences.insert(sequences.end(), columns.sequences().begin(), columns.sequences().end());
          return true;
        });
    EXPECT_TRUE(status.ok()) << status;
    return sequences;
  }

  static std::vector<uint64_t> UpTo(uint64_t last) {
    std::vector<uint64_t> sequences;
    for (uint64_t sequence = 1; sequence <= last; ++sequence) sequences.push_back(sequence);
    return sequences;
  }

  server::TemporaryDirectory directory_;
  server::Config config_;
  server::FrameGate gate_;
  std::unique_ptr<server::Server> server_;
};

// Keeps what a drive tells.
class Recorder {
 public:
  client::DriveObserver Observer() {
    client::DriveObserver observer;
    observer.on_estimate = [this](const v1::FrameEstimate& estimate) {
      MutexLock lock(&mutex_);
      estimates_.push_back(estimate);
    };
    observer.on_dropped = [this](const v1::FramesDropped& dropped) {
      MutexLock lock(&mutex_);
      dropped_.insert(dropped_.end(), dropped.sequences().begin(), dropped.sequences().end());
    };
    observer.on_acknowledgement = [this](const v1::Acknowledgement& acknowledgement) {
      MutexLock lock(&mutex_);
      acknowledged_.push_back(acknowledgement.sequence());
    };
    observer.on_resumed = [this](const v1::SessionStarted&) {
      MutexLock lock(&mutex_);
      ++resumes_;
    };
    return observer;
  }

  std::vector<v1::FrameEstimate> estimates() const {
    MutexLock lock(&mutex_);
    return estimates_;
  }
  std::vector<uint64_t> answered() const {
    std::vector<uint64_t> sequences;
    for (const v1::FrameEstimate& estimate : estimates()) sequences.push_back(estimate.sequence());
    return sequences;
  }
  std::vector<uint64_t> dropped() const {
    MutexLock lock(&mutex_);
    return dropped_;
  }
  std::vector<uint64_t> acknowledged() const {
    MutexLock lock(&mutex_);
    return acknowledged_;
  }
  int resumes() const {
    MutexLock lock(&mutex_);
    return resumes_;
  }

 private:
  mutable Mutex mutex_;  // guards all below
  std::vector<v1::FrameEstimate> estimates_;
  std::vector<uint64_t> dropped_;
  std::vector<uint64_t> acknowledged_;
  int resumes_ = 0;
};

}  // namespace semmap
