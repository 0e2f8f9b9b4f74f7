#include "server/vehicle_session.h"

#include <algorithm>
#include <utility>

#include <spdlog/spdlog.h>

#include "absl/strings/str_cat.h"
#include "absl/time/clock.h"
#include "server/error_reasons.h"
#include "server/frame_decoder.h"
#include "server/names.h"
#include "server/pose_conversion.h"
#include "server/rig_conversion.h"
#include "server/session_anchor.h"
#include "server/session_conversion.h"

namespace semmap::server {
namespace {

// Answers that may have been written and not been read when a stream breaks: the window, and under
// LATEST_WINS the frame in the tracker and the one behind it.
constexpr int kExtraKeptAnswers = 4;
// The store counts frames for sessions that a crash cuts off; exact counts come with the end.
constexpr uint64_t kDeltasBetweenCounterUpdates = 8;
constexpr int kStoreAttempts = 3;
// A vehicle that waits finds the map complete at each frame: its trajectory does not depend on the machine.
constexpr int kMapperBacklog = 0;

// Highest frame that a delta makes durable; 0: none.
uint64_t LastSequence(const MapDelta& delta) {
  uint64_t last = 0;
  for (const FramePose& frame : delta.frames) last = std::max(last, frame.sequence);
  for (const KeyFrameRecord& keyframe : delta.added_keyframes) last = std::max(last, keyframe.sequence);
  return delta.waiting_from > 0 ? std::min(last, delta.waiting_from - 1) : last;
}

// Without payloads, which are not for people.
std::string LogText(const absl::Status& status) {
  return status.ToString(absl::StatusToStringMode::kWithNoExtraData);
}

double MillisecondsBetween(absl::Time start, absl::Time end) {
  return absl::ToDoubleMilliseconds(end - start);
}

// A vehicle that waits gets the classes of its frames, however long that takes.
SlamConfig ForPolicy(SlamConfig config, v1::OverloadPolicy policy) {
  SegmentationConfig& segmentation = config.segmentation;
  if (policy == v1::OVERLOAD_POLICY_BLOCK) {
    segmentation.max_wait_ms = 0;
  } else if (segmentation.mode != SegmentationMode::kOff) {
    segmentation.mode = segmentation.live_mode;
  }
  return config;
}

}  // namespace

VehicleSession::VehicleSession(SessionIdentity identity, const SessionEnvironment& environment)
    : identity_(std::move(identity)),
      environment_(environment),
      queue_(environment.config.credit_window, identity_.policy),
      outbox_(static_cast<size_t>(environment.config.credit_window + kExtraKeptAnswers)) {}

VehicleSession::~VehicleSession() = default;

absl::Status VehicleSession::CreateSlam(const SlamSessionFactory& factory, const SlamConfig& config,
                                        SessionStart start, std::shared_ptr<ExtendedMap> extended) {
  extended_ = std::move(extended);
  const SlamConfig own = ForPolicy(config, identity_.policy);
  keeps_colours_ = own.segmentation.mode != SegmentationMode::kOff;
  auto slam = factory(own, identity_.rig, this, environment_.mappers, std::move(start));
  if (!slam.ok()) {
    const bool bad_rig = slam.status().code() == absl::StatusCode::kInvalidArgument;
    return WithReason(slam.status(), bad_rig ? v1::ERROR_REASON_RIG_INVALID : v1::ERROR_REASON_INTERNAL);
  }
  slam_ = std::move(slam).value();
  return absl::OkStatus();
}

void VehicleSession::SetStored(storage::MapId map, storage::SessionId session) {
  store_map_ = map;
  store_session_ = session;
}

// --- The stream

std::optional<v1::SessionStarted> VehicleSession::Attach(std::shared_ptr<StreamOutput> output, bool resumed,
                                                         uint64_t last_answered) {
  std::shared_ptr<StreamOutput> replaced;
  v1::SessionStarted started;
  {
    MutexLock lock(&mutex_);
    if (over_) return std::nullopt;
    replaced = std::exchange(output_, std::move(output));
    outbox_.Rewind(last_answered);
    started.set_credit(queue_.Restart());
    started.set_last_received_sequence(queue_.last_sequence());
    started.set_last_acknowledged_sequence(acknowledged_);
    if (resumed) ++resumes_;
  }
  if (replaced != nullptr) replaced->Wake();
  started.set_session(SessionName(identity_.id));
  started.set_map(MapName(identity_.map_id));
  started.set_resume_token(identity_.resume_token);
  const auto timeout_ms = static_cast<int64_t>(environment_.config.resume_timeout_s * 1e3);
  started.mutable_resume_timeout()->set_seconds(timeout_ms / 1000);
  started.mutable_resume_timeout()->set_nanos(static_cast<int32_t>(timeout_ms % 1000) * 1'000'000);
  started.mutable_limits()->set_max_message_bytes(int64_t{environment_.config.max_message_mb} << 20);
  started.mutable_limits()->set_max_image_pixels(environment_.config.max_image_pixels);
  return started;
}

std::optional<uint64_t> VehicleSession::Detach(const StreamOutput* output) {
  // Declared first: the last reference must not die under the lock.
  std::shared_ptr<StreamOutput> gone;
  MutexLock lock(&mutex_);
  if (output_.get() != output) return std::nullopt;
  gone = std::exchange(output_, nullptr);
  if (ending_.has_value()) return std::nullopt;
  spdlog::info("stream broke, session waits session={} map={} received={}", identity_.id, identity_.map_id,
               queue_.last_sequence());
  return ++interruptions_;
}

void VehicleSession::EndIfStillInterrupted(uint64_t interruption) {
  {
    MutexLock lock(&mutex_);
    if (output_ != nullptr || interruptions_ != interruption) return;
  }
  End(v1::SESSION_END_REASON_RESUME_TIMEOUT,
      Error(v1::ERROR_REASON_SESSION_NOT_RESUMABLE, "nobody resumed the session in time"));
}

void VehicleSession::Push(StreamOutput* output, v1::Frame frame) {
  absl::Status status;
  {
    MutexLock lock(&mutex_);
    if (output_.get() != output || ending_.has_value()) return;
    status = queue_.Push(std::move(frame), absl::Now());
    if (status.ok()) ScheduleStep();
  }
  if (!status.ok()) {
    End(v1::SESSION_END_REASON_BAD_REQUEST, std::move(status));
    return;
  }
  // There may be credit to give back at once.
  if (identity_.policy == v1::OVERLOAD_POLICY_LATEST_WINS) output->Wake();
}

VehicleSession::Next VehicleSession::NextResponse(const StreamOutput* output,
                                                  v1::StreamFramesResponse* response, absl::Status* status) {
  MutexLock lock(&mutex_);
  if (output_.get() != output) {
    *status = Error(v1::ERROR_REASON_SESSION_RESUMED_ELSEWHERE, "another stream took the session up");
    return Next::kEnd;
  }
  if (outbox_.Take(response)) return Next::kMessage;
  if (announced_ && ending_->status.ok() && !summary_taken_) {
    summary_taken_ = true;
    *response->mutable_summary() = SummaryLocked();
    return Next::kMessage;
  }
  if (announced_) {
    *status = ending_->status;
    return Next::kEnd;
  }
  const int credit = queue_.TakeReturnedCredit();
  if (credit == 0 || ending_.has_value()) return Next::kNothing;
  response->mutable_credit()->set_frames(credit);
  return Next::kMessage;
}

void VehicleSession::Wake() {
  std::shared_ptr<StreamOutput> output;
  {
    MutexLock lock(&mutex_);
    output = output_;
  }
  if (output != nullptr) output->Wake();
}

// --- Frames

void VehicleSession::ScheduleStep() {
  if (stepping_) return;
  stepping_ = true;
  environment_.trackers->Schedule([self = shared_from_this()] { self->Step(); });
}

void VehicleSession::Step() {
  std::optional<QueuedFrame> next;
  bool finish = false;
  {
    MutexLock lock(&mutex_);
    next = queue_.Pop();
    finish = !next.has_value() && ending_.has_value();
    // After the end no step is scheduled any more: stepping_ stays true.
    if (!next.has_value() && !finish) {
      stepping_ = false;
      return;
    }
  }
  if (finish) {
    FinishSlam();
    return;
  }
  Process(*next);
  Wake();
  // Other sessions first: one step at a time keeps the threads fair.
  environment_.trackers->Schedule([self = shared_from_this()] { self->Step(); });
}

void VehicleSession::Process(const QueuedFrame& queued) {
  const absl::Time start = absl::Now();
  auto input = DecodeFrame(queued.frame, identity_.rig, keeps_colours_);
  const absl::Time decoded = absl::Now();
  absl::Status failure = input.status();
  v1::SessionEndReason reason = v1::SESSION_END_REASON_BAD_REQUEST;
  if (input.ok()) {
    // A vehicle that waits for credit has time: its map keeps up with it, however fast it sends.
    if (identity_.policy == v1::OVERLOAD_POLICY_BLOCK)
      slam_->WaitForMapper(environment_.config.mapper_backlog);
    auto result = slam_->Track(*input);
    if (result.ok()) {
      if (queued.frame.has_gnss()) gnss_.Add(queued.frame.sequence(), queued.frame.gnss());
      RecordResult(queued, *result, MillisecondsBetween(queued.arrival, start),
                   MillisecondsBetween(start, decoded));
      return;
    }
    reason = v1::SESSION_END_REASON_INTERNAL;
    failure = WithReason(result.status(), v1::ERROR_REASON_INTERNAL);
  }
  End(reason, std::move(failure));
  DropWaitingFrames();
}

void VehicleSession::RecordResult(const QueuedFrame& queued, const FrameResult& result, double queue_ms,
                                  double decode_ms) {
  const SessionStats stats = slam_->Stats();
  MutexLock lock(&mutex_);
  outbox_.PutDropped(queued.dropped, queue_.dropped());
  outbox_.PutEstimate(ToProto(result, queue_ms, decode_ms));
  queue_.OnProcessed();
  ++processed_;
  if (result.state == TrackingState::kTracking) ++tracked_;
  last_processed_ = result.sequence;
  slam_stats_ = stats;
  track_ms_.Add(result.times.total_ms);
}

// --- The end

void VehicleSession::End(v1::SessionEndReason reason, absl::Status status) {
  MutexLock lock(&mutex_);
  if (ending_.has_value()) return;
  if (status.ok()) {
    spdlog::info("session ends session={} map={} reason={}", identity_.id, identity_.map_id,
                 v1::SessionEndReason_Name(reason));
  } else {
    spdlog::warn("session ends session={} map={} reason={} error={} message=\"{}\"", identity_.id,
                 identity_.map_id, v1::SessionEndReason_Name(reason), ReasonName(ReasonOf(status)),
                 LogText(status));
  }
  ending_ = Ending{reason, std::move(status)};
  ScheduleStep();
}

void VehicleSession::DropWaitingFrames() {
  MutexLock lock(&mutex_);
  queue_.Clear();
}

void VehicleSession::FinishSlam() {
  slam_->Finish();
  const SessionStats stats = slam_->Stats();
  // A session that is over should not hold the memory of its map.
  slam_.reset();
  {
    MutexLock lock(&mutex_);
    slam_stats_ = stats;
  }
  environment_.writer->Post([self = shared_from_this()] { self->StoreEnd(); });
}

void VehicleSession::StoreEnd() {
  const TimestampNs now = environment_.wall_clock();
  storage::SessionCounters counters;
  {
    MutexLock lock(&mutex_);
    counters = Counters();
  }
  const absl::Status status = environment_.store->EndSession(store_map_, store_session_, now, counters);
  if (!status.ok()) spdlog::error("session end not stored session={} {}", identity_.id, LogText(status));
  if (status.ok() && !gnss_.samples().empty()) AnchorMap();

  v1::Session snapshot;
  {
    MutexLock lock(&mutex_);
    if (status.ok() && !DidStoreFail()) {
      acknowledged_ = std::max(acknowledged_, last_processed_);
      outbox_.PutAcknowledgement(acknowledged_);
    } else if (ending_->status.ok()) {
      ending_->status = FromStore(status.ok() ? absl::InternalError("the map was not stored") : status);
    }
    ended_at_ = now;
    over_ = true;
    snapshot = SnapshotLocked();
  }
  // All is stored: who extends the map next may load it.
  extended_.reset();
  AnnounceEnd(snapshot);
  spdlog::info("session over session={} map={} frames={} tracked={} keyframes={} points={}", identity_.id,
               identity_.map_id, counters.frames_received, counters.frames_tracked,
               snapshot.statistics().keyframes(), snapshot.statistics().points());
}

// In the order in which they asked, the vehicle last: the registry was first, so whoever hears of the end
// finds the map free.
void VehicleSession::AnnounceEnd(const v1::Session& last) {
  std::vector<std::function<void(const v1::Session&)>> waiting;
  do {
    for (const auto& function : waiting) function(last);
    waiting.clear();
    MutexLock lock(&mutex_);
    waiting.swap(when_over_);
    announced_ = waiting.empty();
  } while (!waiting.empty());
  Wake();
}

void VehicleSession::AnchorMap() {
  if (identity_.mode == v1::SESSION_MODE_LOCALIZE) return;
  const absl::Status status = AnchorByFixes(*environment_.store, store_map_, store_session_, gnss_);
  if (!status.ok()) {
    spdlog::info("map not anchored session={} map={} {}", identity_.id, identity_.map_id, LogText(status));
  }
}

void VehicleSession::WhenOver(std::function<void(const v1::Session&)> function) {
  v1::Session snapshot;
  {
    MutexLock lock(&mutex_);
    if (!announced_) {
      when_over_.push_back(std::move(function));
      return;
    }
    snapshot = SnapshotLocked();
  }
  function(snapshot);
}

// --- The store

void VehicleSession::OnDelta(MapDelta delta) {
  if (!delta.corrections.empty()) PutCorrections(delta);
  // Corrections alone come from another session's loop; that one stores it.
  if (delta.empty()) {
    Wake();
    return;
  }
  auto shared = std::make_shared<const MapDelta>(std::move(delta));
  environment_.writer->Post([self = shared_from_this(), shared] { self->StoreDelta(*shared); });
}

// At once, not when stored: the next answers come from the corrected map.
void VehicleSession::PutCorrections(const MapDelta& delta) {
  std::vector<v1::MapCorrection> corrections;
  MutexLock lock(&mutex_);
  for (const PoseCorrection& correction : delta.corrections) {
    v1::MapCorrection& proto = corrections.emplace_back();
    proto.set_from_sequence(correction.from_sequence);
    proto.set_through_sequence(std::min(correction.through_sequence, last_processed_));
    *proto.mutable_corrected_from_reported() = ToProto(correction.corrected_from_reported);
    proto.set_map_version(delta.corrected_map_version);
  }
  outbox_.PutCorrections(std::move(corrections));
}

absl::Status VehicleSession::Apply(const MapDelta& delta) {
  absl::Status status;
  for (int attempt = 0; attempt < kStoreAttempts; ++attempt) {
    status = environment_.store->Apply(store_map_, store_session_, delta);
    if (status.code() != absl::StatusCode::kUnavailable) break;
  }
  if (!absl::IsInvalidArgument(status) || identity_.mode != v1::SESSION_MODE_LOCALIZE) return status;
  // Who only reads the map learns late that another session removed a keyframe, on which these frames hang.
  // The map is none the worse for it.
  spdlog::warn("frames not stored session={} map={} {}", identity_.id, identity_.map_id, LogText(status));
  MapDelta nothing;
  nothing.version = delta.version;
  return environment_.store->Apply(store_map_, store_session_, nothing);
}

void VehicleSession::StoreDelta(const MapDelta& delta) {
  if (store_failed_) return;
  // After a delta that is missing, later ones have nothing to stand on.
  const absl::Status status = DidStoreFail()
                                  ? absl::InternalError("the map that others extend as well was not stored")
                                  : Apply(delta);
  if (!status.ok()) {
    spdlog::error("map not stored session={} map={} version={} {}", identity_.id, identity_.map_id,
                  delta.version, LogText(status));
    OnStoreFailed(status);
    return;
  }
  environment_.watchers->OnStored(*environment_.store, store_map_, delta);
  storage::SessionCounters counters;
  {
    MutexLock lock(&mutex_);
    acknowledged_ = std::max(acknowledged_, LastSequence(delta));
    outbox_.PutAcknowledgement(acknowledged_);
    counters = Counters();
  }
  if (++stored_deltas_ % kDeltasBetweenCounterUpdates == 0) {
    const absl::Status updated = environment_.store->UpdateSession(store_map_, store_session_, counters);
    if (!updated.ok()) spdlog::warn("counters not stored session={} {}", identity_.id, LogText(updated));
  }
  Wake();
}

void VehicleSession::OnStoreFailed(absl::Status status) {
  store_failed_ = true;
  if (extended_ != nullptr) extended_->store_failed = true;
  End(v1::SESSION_END_REASON_INTERNAL, FromStore(status));
  DropWaitingFrames();
}

// --- What others see

storage::SessionCounters VehicleSession::Counters() const { return {queue_.received(), tracked_}; }

bool VehicleSession::ending() const {
  MutexLock lock(&mutex_);
  return ending_.has_value();
}

v1::Session VehicleSession::Snapshot() const {
  MutexLock lock(&mutex_);
  return SnapshotLocked();
}

v1::Session VehicleSession::SnapshotLocked() const {
  v1::Session session;
  session.set_name(SessionName(identity_.id));
  session.set_vehicle_id(identity_.vehicle_id);
  session.set_mode(identity_.mode);
  session.set_map(MapName(identity_.map_id));
  *session.mutable_rig() = ToProto(identity_.rig);
  session.set_overload_policy(identity_.policy);
  *session.mutable_create_time() = ToTimestamp(identity_.created_at);
  session.set_state(output_ != nullptr ? v1::SESSION_STATE_ACTIVE : v1::SESSION_STATE_INTERRUPTED);
  if (ending_.has_value()) {
    session.set_state(over_ ? v1::SESSION_STATE_FINISHED : v1::SESSION_STATE_FINISHING);
    if (over_) session.set_end_reason(ending_->reason);
  }
  if (over_) *session.mutable_end_time() = ToTimestamp(ended_at_);
  v1::SessionStatistics* statistics = session.mutable_statistics();
  statistics->set_frames_received(queue_.received());
  statistics->set_frames_processed(processed_);
  statistics->set_frames_tracked(tracked_);
  statistics->set_frames_dropped(queue_.dropped());
  statistics->set_resumes(resumes_);
  statistics->set_keyframes(slam_stats_.keyframes);
  statistics->set_points(slam_stats_.points);
  statistics->set_frames_classified(slam_stats_.classified_frames);
  statistics->set_frames_unclassified(slam_stats_.unclassified_frames);
  session.set_last_received_sequence(queue_.last_sequence());
  session.set_last_acknowledged_sequence(acknowledged_);
  return session;
}

v1::SessionSummary VehicleSession::SummaryLocked() const {
  v1::SessionSummary summary;
  *summary.mutable_session() = SnapshotLocked();
  summary.set_track_ms_median(track_ms_.Quantile(0.5));
  summary.set_track_ms_p95(track_ms_.Quantile(0.95));
  return summary;
}

}  // namespace semmap::server
