#include "server/handlers/watch_map.h"

#include <algorithm>
#include <atomic>

#include "handler_fixture.h"

namespace semmap::server {
namespace {

// A viewer of a map of 10 keyframes and points (see MakeMap) that keeps what it was told.
class WatchMapTest : public HandlerTest {
 protected:
  WatchMapTest() {
    MakeMap("town", "s1", 50);
    map_ = store_->GetMap("town")->id;
    request_.set_map("maps/town");
  }

  void Watch() {
    auto source = WatchSource::Make(context_, request_, [this] { ++wakes_; });
    ASSERT_TRUE(source.ok()) << source.status();
    source_ = *std::move(source);
  }

  // Takes all that there is to tell now.
  absl::Status Follow() {
    while (true) {
      v1::WatchMapResponse response;
      const auto more = source_->Next(&response);
      if (!more.ok()) return more.status();
      if (!*more) return absl::OkStatus();
      ++messages_;
      if (response.reset()) {
        keyframes_.clear();
        points_.clear();
      }
      for (const v1::KeyFrame& keyframe : response.keyframes()) keyframes_[keyframe.id()] = keyframe;
      for (const uint64_t id : response.removed_keyframe_ids()) keyframes_.erase(id);
      for (int i = 0; i < response.points().ids_size(); ++i) {
        points_[response.points().ids(i)] = response.points().positions(3 * i);
      }
      for (const uint64_t id : response.removed_point_ids()) points_.erase(id);
      version_ = response.map_version();
    }
  }

  // A vehicle goes on: a delta of the mapper reaches the store.
  void Store(MapDelta delta) {
    if (!session_.IsValid()) session_ = store_->StartSession({map_, "s2", "bus", 3, SmallRig()})->id;
    delta.version = ++delta_version_;
    const absl::Status status = store_->Apply(map_, session_, delta);
    ASSERT_TRUE(status.ok()) << status;
    watchers_.OnStored(*store_, map_, delta);
  }

  static MapPointRecord PointAt(uint64_t id, double x) {
    MapPointRecord point;
    point.id = MapPointId(id);
    point.position_in_map = {x, 0, 10};
    point.reference_keyframe = KeyFrameId(1);
    return point;
  }

  storage::MapId map_;
  storage::SessionId session_;
  uint64_t delta_version_ = 0;
  v1::WatchMapRequest request_;
  std::atomic<int> wakes_ = 0;
  std::unique_ptr<WatchSource> source_;
  int messages_ = 0;
  uint64_t version_ = 0;
  std::map<uint64_t, v1::KeyFrame> keyframes_;
  std::map<uint64_t, double> points_;  // x of each
};

TEST_F(WatchMapTest, BeginsWithAllThatIsThere) {
  context_.config.query_chunk = 3;
  Watch();
  ASSERT_TRUE(Follow().ok());
  EXPECT_EQ(keyframes_.size(), 10U);
  EXPECT_EQ(keyframes_.at(2).session(), "sessions/s1");
  EXPECT_EQ(points_.size(), 10U);
  EXPECT_EQ(points_.at(2), 6);
  EXPECT_EQ(version_, store_->GetMap(map_)->version);
  EXPECT_GE(messages_, 8);
  EXPECT_FALSE(source_->HasNews());
}

TEST_F(WatchMapTest, WhoKnowsTheVersionIsToldOnlyWhatChanges) {
  request_.set_after_version(store_->GetMap(map_)->version);
  Watch();
  ASSERT_TRUE(Follow().ok());
  EXPECT_EQ(messages_, 0);
  MapDelta delta;
  delta.upserted_points = {PointAt(11, 70), PointAt(2, 6.5)};
  delta.moved_keyframes.push_back(
      {KeyFrameId(3), SE3(Eigen::Quaterniond::Identity(), {1, 2, 3}), KeyFrameId(2)});
  Store(delta);
  EXPECT_EQ(wakes_, 1);
  ASSERT_TRUE(Follow().ok());
  EXPECT_EQ(messages_, 1);
  EXPECT_EQ(points_, (std::map<uint64_t, double>{{2, 6.5}, {11, 70}}));
  ASSERT_EQ(keyframes_.size(), 1U);
  EXPECT_EQ(keyframes_.at(3).map_from_camera().translation().z(), 3);
  EXPECT_EQ(version_, store_->GetMap(map_)->version);
}

TEST_F(WatchMapTest, AnOldVersionBeginsAnew) {
  request_.set_after_version(3);
  Watch();
  ASSERT_TRUE(Follow().ok());
  EXPECT_EQ(points_.size(), 10U);
}

TEST_F(WatchMapTest, ChangesOfOneThingAreToldOnce) {
  Watch();
  ASSERT_TRUE(Follow().ok());
  messages_ = 0;
  for (int i = 0; i < 5; ++i) {
    MapDelta delta;
    delta.upserted_points = {PointAt(1, 100 + i)};
    Store(delta);
  }
  ASSERT_TRUE(Follow().ok());
  EXPECT_EQ(messages_, 1);
  EXPECT_EQ(points_.at(1), 104);
}

TEST_F(WatchMapTest, WhatGoesIsForgotten) {
  Watch();
  ASSERT_TRUE(Follow().ok());
  MapDelta delta;
  delta.removed_points = {MapPointId(4)};
  delta.removed_keyframes.push_back({KeyFrameId(5), KeyFrameId(4), SE3()});
  Store(delta);
  ASSERT_TRUE(Follow().ok());
  EXPECT_FALSE(points_.contains(4));
  EXPECT_FALSE(keyframes_.contains(5));
  EXPECT_EQ(keyframes_.size(), 9U);
  EXPECT_EQ(points_.size(), 9U);
}

TEST_F(WatchMapTest, AVersionIsToldWhenAllOfItIs) {
  Watch();
  ASSERT_TRUE(Follow().ok());
  context_.config.query_chunk = 2;
  MapDelta delta;
  for (uint64_t id = 11; id <= 15; ++id) delta.upserted_points.push_back(PointAt(id, 0));
  Store(delta);
  v1::WatchMapResponse response;
  ASSERT_TRUE(*source_->Next(&response));
  EXPECT_EQ(response.map_version(), 0U);
  ASSERT_TRUE(Follow().ok());
  EXPECT_EQ(version_, store_->GetMap(map_)->version);
}

TEST_F(WatchMapTest, OnlyKeyframes) {
  request_.set_keyframes_only(true);
  Watch();
  ASSERT_TRUE(Follow().ok());
  EXPECT_EQ(keyframes_.size(), 10U);
  EXPECT_TRUE(points_.empty());
}

TEST_F(WatchMapTest, AWatcherThatIsTooSlowIsEnded) {
  context_.config.watcher_backlog = 3;
  Watch();
  ASSERT_TRUE(Follow().ok());
  MapDelta delta;
  for (uint64_t id = 11; id <= 14; ++id) delta.upserted_points.push_back(PointAt(id, 0));
  Store(delta);
  EXPECT_TRUE(source_->HasNews());
  EXPECT_EQ(ReasonOf(Follow()), v1::ERROR_REASON_WATCHER_TOO_SLOW);
}

TEST_F(WatchMapTest, ARepairedMapIsToldAnewADeletedOneEnds) {
  Watch();
  ASSERT_TRUE(Follow().ok());
  messages_ = 0;
  watchers_.OnReset(map_);
  EXPECT_TRUE(source_->HasNews());
  ASSERT_TRUE(Follow().ok());
  EXPECT_GE(messages_, 2);
  EXPECT_EQ(points_.size(), 10U);
  ASSERT_TRUE(store_->DeleteMap(map_).ok());
  watchers_.OnReset(map_);
  EXPECT_EQ(ReasonOf(Follow()), v1::ERROR_REASON_MAP_NOT_FOUND);
}

TEST_F(WatchMapTest, MapsThatAreNotThere) {
  request_.set_map("maps/nowhere");
  EXPECT_EQ(ReasonOf(WatchSource::Make(context_, request_, [] {}).status()), v1::ERROR_REASON_MAP_NOT_FOUND);
}

}  // namespace
}  // namespace semmap::server
