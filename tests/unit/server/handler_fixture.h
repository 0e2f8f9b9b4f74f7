#pragma once

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "fake_session.h"
#include "server/error_reasons.h"
#include "server/service_context.h"
#include "temporary_store.h"

namespace semmap::server {

// Applies deltas at once.
class StoringSink : public MapDeltaSink {
 public:
  StoringSink(storage::MapStore* store, storage::MapId map, storage::SessionId session)
      : store_(store), map_(map), session_(session) {}
  void OnDelta(MapDelta delta) override { EXPECT_TRUE(store_->Apply(map_, session_, delta).ok()); }

 private:
  storage::MapStore* store_;
  storage::MapId map_;
  storage::SessionId session_;
};

inline CameraRig SmallRig() {
  CameraRig rig;
  rig.camera.width = 64;
  rig.camera.height = 48;
  rig.camera.fx = 50;
  rig.camera.fy = 50;
  rig.camera.cx = 32;
  rig.camera.cy = 24;
  return rig;
}

// A store in a temporary directory and all that handlers want, without network.
class HandlerTest : public testing::Test {
 protected:
  HandlerTest() {
    environment_.store = store_.get();
    environment_.trackers = threads_.get();
    environment_.mappers = threads_.get();
    environment_.writer = &writer_;
    environment_.watchers = &watchers_;
    environment_.wall_clock = [] { return TimestampNs{1'700'000'000'000'000'000}; };
    environment_.maps = &maps_;
    sessions_ =
        std::make_unique<SessionRegistry>(environment_, SlamConfig(), FakeSession::Factory(&gate_), &timer_);
    context_ = {
        environment_.config, store_.get(), sessions_.get(),         &requests_,   &timer_, &operations_,
        &artifacts_,         &watchers_,   environment_.wall_clock, SlamConfig(), &maps_};
  }
  ~HandlerTest() override {
    gate_.Open();
    sessions_->Drain(absl::Seconds(10));
  }

  // A map as a finished session of `frames` frames leaves it: frame s is at x = s and time 100 s, every fifth
  // one a keyframe with one point ten metres ahead, of classes 10 and 1 in turn.
  void MakeMap(const std::string& map_name, const std::string& session_name, uint64_t frames) {
    const auto map = store_->CreateMap({map_name, 1, SmallRig(), false});
    ASSERT_TRUE(map.ok()) << map.status();
    const auto session = store_->StartSession({map->id, session_name, "car", 1, SmallRig()});
    ASSERT_TRUE(session.ok()) << session.status();
    StoringSink sink(store_.get(), map->id, session->id);
    FakeSession slam(&sink, nullptr);
    for (uint64_t sequence = 1; sequence <= frames; ++sequence) {
      FrameInput frame;
      frame.sequence = sequence;
      frame.timestamp = static_cast<TimestampNs>(sequence) * 100;
      ASSERT_TRUE(slam.Track(frame).ok());
    }
    slam.Finish();
    ASSERT_TRUE(store_->EndSession(map->id, session->id, 2, {frames, frames}).ok());
  }

  // A session that runs; its stream is nobody's.
  std::shared_ptr<VehicleSession> OpenSession(const std::string& map_name) {
    v1::SessionHello hello;
    hello.set_vehicle_id("car");
    hello.set_map("maps/" + map_name);
    hello.set_mode(v1::SESSION_MODE_MAP);
    hello.mutable_rig()->set_sensor(v1::SENSOR_TYPE_MONO);
    v1::CameraIntrinsics* camera = hello.mutable_rig()->mutable_camera();
    camera->set_width(64);
    camera->set_height(48);
    camera->set_fx(50);
    camera->set_fy(50);
    camera->set_cx(32);
    camera->set_cy(24);
    camera->set_distortion_model(v1::DISTORTION_MODEL_NONE);
    auto opened = sessions_->Open(hello);
    EXPECT_TRUE(opened.ok()) << opened.status();
    return opened.ok() ? opened->session : nullptr;
  }

  TemporaryDirectory directory_;
  std::unique_ptr<storage::MapStore> store_ = OpenStoreIn(directory_);
  MapWriter writer_{16};
  MapWatchers watchers_;
  std::unique_ptr<Executor> threads_ = MakeThreadPool(2);
  SessionEnvironment environment_;
  FrameGate gate_;
  RequestLog requests_;
  Artifacts artifacts_{directory_.path() + "/artifacts", 1 << 20, absl::Seconds(60),
                       [this] { return environment_.wall_clock(); }};
  Timer timer_;
  std::unique_ptr<Executor> workers_ = MakeThreadPool(1);
  Operations operations_{workers_.get(), [] { return TimestampNs{1'700'000'000'000'000'000}; }};
  std::unique_ptr<Executor> loaders_ = MakeThreadPool(1);
  MapCache maps_{{}, MakeMapLoader(store_.get(), SlamConfig(), nullptr), loaders_.get()};
  std::unique_ptr<SessionRegistry> sessions_;
  ServiceContext context_;
};

}  // namespace semmap::server
