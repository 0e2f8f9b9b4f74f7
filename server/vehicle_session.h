#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/base/thread_annotations.h"
#include "absl/status/status.h"
#include "semmap/v1/session.pb.h"
#include "server/frame_queue.h"
#include "server/gnss_track.h"
#include "server/latency_histogram.h"
#include "server/map_cache.h"
#include "server/map_watchers.h"
#include "server/map_writer.h"
#include "server/server_config.h"
#include "server/shared_maps.h"
#include "server/stream_outbox.h"
#include "slam/common/mutex.h"
#include "slam/map/map_delta.h"
#include "slam/pipeline/executor.h"
#include "slam/pipeline/session.h"
#include "storage/map_store.h"

namespace semmap::server {

// Makes the SLAM session of a vehicle; semmap::Session::Create in production.
using SlamSessionFactory = std::function<absl::StatusOr<std::unique_ptr<Session>>(
    const SlamConfig& config, const CameraRig& rig, MapDeltaSink* sink, Executor* executor,
    SessionStart start)>;

// What all sessions of a server share. Pointers outlive every session.
struct SessionEnvironment {
  ServerConfig config;
  storage::MapStore* store = nullptr;
  // Mappers have threads of their own: a tracker may wait for its mapper.
  Executor* trackers = nullptr;
  Executor* mappers = nullptr;
  MapWriter* writer = nullptr;
  MapWatchers* watchers = nullptr;
  std::function<TimestampNs()> wall_clock;  // Unix epoch
  MapCache* maps = nullptr;                 // null: no session in stored maps
};

// Who drives where.
struct SessionIdentity {
  std::string id;  // of "sessions/{id}"
  std::string resume_token;
  std::string vehicle_id;
  std::string map_id;  // of "maps/{id}"
  std::string request_id;
  v1::SessionMode mode = v1::SESSION_MODE_MAP;
  v1::OverloadPolicy policy = v1::OVERLOAD_POLICY_BLOCK;
  CameraRig rig;
  TimestampNs created_at = 0;
};

// The stream that a session speaks through.
class StreamOutput {
 public:
  virtual ~StreamOutput() = default;
  // There is something to take by VehicleSession::NextResponse. Called from any thread, without locks.
  virtual void Wake() = 0;
};

// One vehicle's drive, from hello to the last byte in the store; knows no network. Frames go, one at a time
// and in order, through decoder and tracker on the shared tracker threads; changes of the map go through the
// writer to the store. A session outlives its stream: without one it waits to be resumed. Thread-safe.
//
//   Active <-> Interrupted        stream attached, or waiting for one
//      \          /
//       Finishing -> Finished     End(): queue worked off, mapper drained, everything stored
class VehicleSession : public std::enable_shared_from_this<VehicleSession>, private MapDeltaSink {
 public:
  enum class Next { kMessage, kNothing, kEnd };

  VehicleSession(SessionIdentity identity, const SessionEnvironment& environment);
  ~VehicleSession() override;
  VehicleSession(const VehicleSession&) = delete;
  VehicleSession& operator=(const VehicleSession&) = delete;

  // Both before anything else. RIG_INVALID when SLAM does not take the rig.
  // `extended`: the map of `start.extend`, or null.
  absl::Status CreateSlam(const SlamSessionFactory& factory, const SlamConfig& config, SessionStart start,
                          std::shared_ptr<ExtendedMap> extended);
  void SetStored(storage::MapId map, storage::SessionId session);

  const SessionIdentity& identity() const { return identity_; }

  // From now on `output` is the session's stream; one it had before is told so by NextResponse. nullopt when
  // the session is over. `last_answered`: as in v1::SessionResume.
  std::optional<v1::SessionStarted> Attach(std::shared_ptr<StreamOutput> output, bool resumed,
                                           uint64_t last_answered);
  // The stream is gone. Nothing happens if it is not the session's any more; otherwise the session waits, and
  // the result names this interruption.
  std::optional<uint64_t> Detach(const StreamOutput* output);
  // Ends the session if it is still in that interruption.
  void EndIfStillInterrupted(uint64_t interruption);

  // A frame arrived by `output`. A frame that cannot be taken ends the session.
  void Push(StreamOutput* output, v1::Frame frame);

  // Takes no more frames, works off those it has, stores everything. `status` is what the stream ends with.
  // Only the first call counts.
  void End(v1::SessionEndReason reason, absl::Status status);
  // Frames that wait for the tracker are left out.
  void DropWaitingFrames();
  // Called once, as soon as all is stored; at once if it is. Not with the session's lock held.
  void WhenOver(std::function<void(const v1::Session&)> function);

  // What `output` should write next; kEnd comes with the status of the stream.
  Next NextResponse(const StreamOutput* output, v1::StreamFramesResponse* response, absl::Status* status);

  // End was called.
  bool ending() const;
  // As GetSession answers.
  v1::Session Snapshot() const;

 private:
  struct Ending {
    v1::SessionEndReason reason = v1::SESSION_END_REASON_UNSPECIFIED;
    absl::Status status;
  };

  void OnDelta(MapDelta delta) override;

  // On the tracker threads, never two at a time.
  void Step();
  void Process(const QueuedFrame& queued);
  void FinishSlam();
  // On the writer's thread.
  void PutCorrections(const MapDelta& delta);
  void StoreDelta(const MapDelta& delta);
  bool DidStoreFail() const { return store_failed_ || (extended_ != nullptr && extended_->store_failed); }
  void OnStoreFailed(absl::Status status);
  absl::Status Apply(const MapDelta& delta);
  void StoreEnd();
  void AnnounceEnd(const v1::Session& last);
  void AnchorMap();

  void RecordResult(const QueuedFrame& queued, const FrameResult& result, double queue_ms, double decode_ms);
  void Wake();
  void ScheduleStep() ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  storage::SessionCounters Counters() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  v1::Session SnapshotLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  v1::SessionSummary SummaryLocked() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);

  const SessionIdentity identity_;
  const SessionEnvironment environment_;
  storage::MapId store_map_;
  storage::SessionId store_session_;

  // Touched by Step alone, and by StoreEnd, which the last step posts.
  std::unique_ptr<Session> slam_;
  bool keeps_colours_ = false;
  GnssTrack gnss_;
  // Set before anything else; held, touched and given back on the writer's thread.
  std::shared_ptr<ExtendedMap> extended_;
  // Touched by the writer's thread alone.
  bool store_failed_ = false;
  uint64_t stored_deltas_ = 0;

  mutable Mutex mutex_;  // guards all below
  FrameQueue queue_ ABSL_GUARDED_BY(mutex_);
  StreamOutbox outbox_ ABSL_GUARDED_BY(mutex_);
  std::shared_ptr<StreamOutput> output_ ABSL_GUARDED_BY(mutex_);
  bool stepping_ ABSL_GUARDED_BY(mutex_) = false;  // a Step is scheduled or runs
  std::optional<Ending> ending_ ABSL_GUARDED_BY(mutex_);
  bool over_ ABSL_GUARDED_BY(mutex_) = false;       // stored
  bool announced_ ABSL_GUARDED_BY(mutex_) = false;  // over, and all who asked have been told
  bool summary_taken_ ABSL_GUARDED_BY(mutex_) = false;
  uint64_t interruptions_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t resumes_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t processed_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t tracked_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t last_processed_ ABSL_GUARDED_BY(mutex_) = 0;
  uint64_t acknowledged_ ABSL_GUARDED_BY(mutex_) = 0;
  TimestampNs ended_at_ ABSL_GUARDED_BY(mutex_) = 0;
  SessionStats slam_stats_ ABSL_GUARDED_BY(mutex_);
  LatencyHistogram track_ms_ ABSL_GUARDED_BY(mutex_);
  std::vector<std::function<void(const v1::Session&)>> when_over_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace semmap::server
