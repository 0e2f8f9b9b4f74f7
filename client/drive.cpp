#include "client/drive.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <grpcpp/grpcpp.h>

#include "absl/base/thread_annotations.h"
#include "absl/time/clock.h"
#include "client/client.h"
#include "client/drive_stream.h"
#include "client/errors.h"
#include "client/frame_keeper.h"
#include "client/names.h"
#include "client/request_id.h"
#include "slam/common/mutex.h"

namespace semmap::client {
namespace {

constexpr absl::Duration kFirstBackoff = absl::Milliseconds(50);
constexpr absl::Duration kLongestBackoff = absl::Seconds(2);

// Whether a stream that ended like this may be taken up again: the link failed, the service did not refuse
// anything.
bool IsBroken(const absl::Status& status) {
  if (!ErrorReason(status).empty()) return false;
  switch (status.code()) {
    case absl::StatusCode::kUnavailable:
    case absl::StatusCode::kCancelled:
    case absl::StatusCode::kInternal:
    case absl::StatusCode::kUnknown:
      return true;
    default:
      return false;
  }
}

absl::Duration Milliseconds(std::chrono::milliseconds duration) { return absl::FromChrono(duration); }

class StreamingDrive : public Drive {
 public:
  StreamingDrive(std::shared_ptr<Connection> connection, DriveOptions options, DriveObserver observer)
      : connection_(std::move(connection)),
        stub_(connection_->channel()),
        options_(std::move(options)),
        observer_(std::move(observer)),
        keeper_(options_.max_kept_frames) {}

  ~StreamingDrive() override { CloseStream(); }

  absl::Status Begin();

  const v1::SessionStarted& started() const override { return first_started_; }
  absl::Status Send(v1::Frame frame) override;
  bool HasCredit() const override;
  absl::Status WaitForAnswers(std::chrono::milliseconds timeout) override;
  absl::StatusOr<v1::SessionSummary> Finish() override;
  void CutStream() override;

 private:
  // Of the stream's life, as its callbacks tell it.
  bool HasStartedOrEnded() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return started_.has_value() || ended_.has_value();
  }
  bool MayWriteOrEnded() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return credit_ > 0 || !keeper_.HasUnwritten() || ended_.has_value();
  }
  bool IsAnsweredOrEnded() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) {
    return keeper_.last_answered() >= keeper_.last_added() || ended_.has_value();
  }
  bool HasEnded() const ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_) { return ended_.has_value(); }

  void OnMessage(const v1::StreamFramesResponse& response);
  void Apply(const v1::StreamFramesResponse& response);
  void OnStarted(const v1::SessionStarted& started) ABSL_EXCLUSIVE_LOCKS_REQUIRED(mutex_);
  void Observe(const v1::StreamFramesResponse& response) const;
  void OnEnd(const absl::Status& status);

  absl::Status OpenStream(v1::StreamFramesRequest first);
  void CloseStream();
  // After the stream ended: OK when another one has taken its place.
  absl::Status Recover();
  absl::Status TryResume(absl::Duration limit);
  // Writes the frames that wait, as far as there is credit, until none waits or `deadline`.
  absl::Status WriteFrames(absl::Time deadline);
  absl::Status WaitForCredit(absl::Time deadline);
  absl::Status WriteEnd(absl::Time deadline);
  absl::StatusOr<v1::SessionSummary> SummaryOfFinished(const absl::Status& failure);

  const std::shared_ptr<Connection> connection_;
  v1::SessionService::Stub stub_;
  const DriveOptions options_;
  const DriveObserver observer_;
  v1::SessionStarted first_started_;
  bool end_sent_ = false;
  std::unique_ptr<DriveStream> stream_;

  mutable Mutex mutex_;  // guards all below
  FrameKeeper keeper_ ABSL_GUARDED_BY(mutex_);
  std::optional<v1::SessionStarted> started_ ABSL_GUARDED_BY(mutex_);
  std::optional<absl::Status> ended_ ABSL_GUARDED_BY(mutex_);
  std::optional<v1::SessionSummary> summary_ ABSL_GUARDED_BY(mutex_);
  int credit_ ABSL_GUARDED_BY(mutex_) = 0;
};

// --- What the server says

void StreamingDrive::OnMessage(const v1::StreamFramesResponse& response) {
  // In this order: who waits for an answer finds that the observer has seen it.
  Observe(response);
  Apply(response);
}

void StreamingDrive::OnStarted(const v1::SessionStarted& started) {
  credit_ = started.credit();
  keeper_.Rewind(started.last_received_sequence());
  started_ = started;
}

void StreamingDrive::Apply(const v1::StreamFramesResponse& response) {
  MutexLock lock(&mutex_);
  switch (response.response_case()) {
    case v1::StreamFramesResponse::kStarted:
      OnStarted(response.started());
      break;
    case v1::StreamFramesResponse::kEstimate:
      keeper_.OnAnswered(response.estimate().sequence());
      break;
    case v1::StreamFramesResponse::kDropped:
      for (const uint64_t sequence : response.dropped().sequences()) keeper_.OnAnswered(sequence);
      break;
    case v1::StreamFramesResponse::kAcknowledgement:
      keeper_.OnAcknowledged(response.acknowledgement().sequence());
      break;
    case v1::StreamFramesResponse::kCredit:
      credit_ += response.credit().frames();
      break;
    case v1::StreamFramesResponse::kSummary:
      summary_ = response.summary();
      break;
    default:  // corrections are the observer's; what newer servers send is passed over
      break;
  }
}

void StreamingDrive::Observe(const v1::StreamFramesResponse& response) const {
  if (response.has_estimate() && observer_.on_estimate) observer_.on_estimate(response.estimate());
  if (response.has_dropped() && observer_.on_dropped) observer_.on_dropped(response.dropped());
  if (response.has_correction() && observer_.on_correction) observer_.on_correction(response.correction());
  if (response.has_acknowledgement() && observer_.on_acknowledgement) {
    observer_.on_acknowledgement(response.acknowledgement());
  }
}

void StreamingDrive::OnEnd(const absl::Status& status) {
  MutexLock lock(&mutex_);
  ended_ = status;
}

// --- Streams

absl::Status StreamingDrive::OpenStream(v1::StreamFramesRequest first) {
  CloseStream();
  {
    MutexLock lock(&mutex_);
    started_.reset();
    ended_.reset();
    credit_ = 0;
  }
  stream_ = DriveStream::Open(
      &stub_, [this](const v1::StreamFramesResponse& response) { OnMessage(response); },
      [this](const absl::Status& status) { OnEnd(status); });
  const auto timeout = connection_->options().call_timeout;
  stream_->Write(std::move(first), timeout);
  {
    MutexLock lock(&mutex_);
    if (mutex_.AwaitWithTimeout(Milliseconds(timeout), &StreamingDrive::HasStartedOrEnded, this)) {
      return started_.has_value() ? absl::OkStatus() : *ended_;
    }
  }
  CloseStream();
  return absl::DeadlineExceededError("the server did not answer the first message of the stream");
}

// Afterwards no callback of the stream is running or will come.
void StreamingDrive::CloseStream() {
  if (stream_ == nullptr) return;
  stream_->Cancel();
  MutexLock lock(&mutex_);
  mutex_.Await(&StreamingDrive::HasEnded, this);
  stream_.reset();
}

absl::Status StreamingDrive::Begin() {
  v1::StreamFramesRequest first;
  v1::SessionHello* hello = first.mutable_hello();
  hello->set_vehicle_id(options_.vehicle_id);
  hello->set_mode(options_.mode);
  hello->set_map(MapName(options_.map));
  *hello->mutable_rig() = options_.rig;
  hello->set_overload_policy(options_.overload_policy);
  hello->set_user_agent(options_.user_agent);
  hello->set_request_id(NewRequestId());
  if (absl::Status status = OpenStream(std::move(first)); !status.ok()) return status;
  MutexLock lock(&mutex_);
  first_started_ = *started_;
  return absl::OkStatus();
}

absl::Status StreamingDrive::TryResume(absl::Duration limit) {
  const absl::Time connected_by =
      absl::Now() + std::min(limit, Milliseconds(connection_->options().connect_timeout));
  if (!connection_->channel()->WaitForConnected(absl::ToChronoTime(connected_by))) {
    return absl::UnavailableError("the server cannot be reached");
  }
  v1::StreamFramesRequest first;
  v1::SessionResume* resume = first.mutable_resume();
  resume->set_session(first_started_.session());
  resume->set_resume_token(first_started_.resume_token());
  {
    MutexLock lock(&mutex_);
    resume->set_last_answered_sequence(keeper_.last_answered());
  }
  return OpenStream(std::move(first));
}

absl::Status StreamingDrive::Recover() {
  absl::Status status;
  {
    MutexLock lock(&mutex_);
    status = ended_.value_or(absl::InternalError("the stream has not ended"));
  }
  if (status.ok()) status = absl::AbortedError("the server ended the stream");
  const absl::Duration window = absl::Seconds(first_started_.resume_timeout().seconds()) +
                                absl::Nanoseconds(first_started_.resume_timeout().nanos());
  const absl::Time give_up = absl::Now() + window;
  absl::Duration backoff = kFirstBackoff;
  while (options_.resume && IsBroken(status) && absl::Now() < give_up) {
    status = TryResume(give_up - absl::Now());
    if (status.ok()) {
      if (observer_.on_resumed) {
        MutexLock lock(&mutex_);
        observer_.on_resumed(*started_);
      }
      return status;
    }
    if (IsBroken(status)) absl::SleepFor(std::min(backoff, give_up - absl::Now()));
    backoff = std::min(2 * backoff, kLongestBackoff);
  }
  return status;
}

void StreamingDrive::CutStream() {
  if (stream_ != nullptr) stream_->Cancel();
}

// --- Frames

absl::Status StreamingDrive::WaitForCredit(absl::Time deadline) {
  MutexLock lock(&mutex_);
  if (mutex_.AwaitWithDeadline(deadline, &StreamingDrive::MayWriteOrEnded, this)) return absl::OkStatus();
  return absl::DeadlineExceededError("the server gave no credit in time");
}

absl::Status StreamingDrive::WriteFrames(absl::Time deadline) {
  while (true) {
    if (absl::Status status = WaitForCredit(deadline); !status.ok()) return status;
    v1::StreamFramesRequest request;
    bool ended = false;
    {
      MutexLock lock(&mutex_);
      ended = ended_.has_value();
      if (!ended) {
        if (!keeper_.HasUnwritten()) return absl::OkStatus();
        *request.mutable_frame() = keeper_.TakeUnwritten();
        --credit_;
      }
    }
    if (ended) {
      if (absl::Status status = Recover(); !status.ok()) return status;
      continue;
    }
    // A write that fails is followed by the stream's end.
    if (stream_->Write(std::move(request), options_.send_timeout)) continue;
    MutexLock lock(&mutex_);
    mutex_.Await(&StreamingDrive::HasEnded, this);
  }
}

absl::Status StreamingDrive::Send(v1::Frame frame) {
  {
    MutexLock lock(&mutex_);
    keeper_.Add(std::move(frame));
  }
  return WriteFrames(absl::Now() + Milliseconds(options_.send_timeout));
}

bool StreamingDrive::HasCredit() const {
  MutexLock lock(&mutex_);
  return credit_ > 0 && !ended_.has_value();
}

absl::Status StreamingDrive::WaitForAnswers(std::chrono::milliseconds timeout) {
  const absl::Time deadline = absl::Now() + Milliseconds(timeout);
  while (true) {
    bool ended = false;
    {
      MutexLock lock(&mutex_);
      if (!mutex_.AwaitWithDeadline(deadline, &StreamingDrive::IsAnsweredOrEnded, this)) {
        return absl::DeadlineExceededError("the server did not answer all frames in time");
      }
      if (keeper_.last_answered() >= keeper_.last_added()) return absl::OkStatus();
      ended = ended_.has_value();
    }
    if (!ended) continue;
    if (absl::Status status = Recover(); !status.ok()) return status;
    if (absl::Status status = WriteFrames(deadline); !status.ok()) return status;
  }
}

// --- The end

absl::Status StreamingDrive::WriteEnd(absl::Time deadline) {
  if (absl::Status status = WriteFrames(deadline); !status.ok()) return status;
  v1::StreamFramesRequest request;
  request.mutable_end();
  end_sent_ = true;
  stream_->Write(std::move(request), options_.send_timeout);
  return absl::OkStatus();
}

absl::StatusOr<v1::SessionSummary> StreamingDrive::Finish() {
  if (stream_ == nullptr) return absl::FailedPreconditionError("the drive is finished");
  const absl::Time deadline = absl::Now() + Milliseconds(options_.finish_timeout);
  while (true) {
    if (absl::Status status = WriteEnd(deadline); !status.ok()) return SummaryOfFinished(status);
    {
      MutexLock lock(&mutex_);
      if (!mutex_.AwaitWithDeadline(deadline, &StreamingDrive::HasEnded, this)) {
        return absl::DeadlineExceededError("the server did not store the session in time");
      }
      if (ended_->ok() && summary_.has_value()) return *summary_;
    }
    if (absl::Status status = Recover(); !status.ok()) return SummaryOfFinished(status);
  }
}

// A stream that broke after the end was sent may have missed the summary of a session that ended well.
absl::StatusOr<v1::SessionSummary> StreamingDrive::SummaryOfFinished(const absl::Status& failure) {
  {
    // The stream may have come to its end faster than the frames and the end message were repeated.
    MutexLock lock(&mutex_);
    if (summary_.has_value()) return *summary_;
  }
  if (!end_sent_ || ErrorReason(failure) != "SESSION_NOT_RESUMABLE") return failure;
  const auto session = Client(connection_).GetSession(first_started_.session());
  if (!session.ok() || session->end_reason() != v1::SESSION_END_REASON_CLIENT) return failure;
  v1::SessionSummary summary;
  *summary.mutable_session() = *session;
  return summary;
}

}  // namespace

absl::StatusOr<std::unique_ptr<Drive>> Drive::Start(std::shared_ptr<Connection> connection,
                                                    DriveOptions options, DriveObserver observer) {
  auto drive =
      std::make_unique<StreamingDrive>(std::move(connection), std::move(options), std::move(observer));
  if (absl::Status status = drive->Begin(); !status.ok()) return status;
  return drive;
}

}  // namespace semmap::client
