#include "server/rpc/stream_frames.h"

#include <utility>

#include "server/error_reasons.h"
#include "server/rpc/grpc_status.h"
#include "slam/common/status_macros.h"

namespace semmap::server {
namespace {

absl::Status Unexpected(const char* what) { return Error(v1::ERROR_REASON_MESSAGE_UNEXPECTED, what); }

}  // namespace

FrameStream* FrameStream::Start(CallRunner& runner) {
  std::shared_ptr<FrameStream> stream(new FrameStream(runner));  // NOLINT: the constructor is private
  stream->self_ = stream;
  runner.context().timer->After(absl::Seconds(runner.context().config.hello_timeout_s),
                                [weak = std::weak_ptr<FrameStream>(stream)] {
                                  if (const auto waiting = weak.lock()) waiting->EndUnlessOpened();
                                });
  stream->StartRead(&stream->request_);
  return stream.get();
}

void FrameStream::EndUnlessOpened() {
  {
    MutexLock lock(&mutex_);
    if (first_seen_) return;
  }
  End(Unexpected("no hello came in time"));
}

// --- Reading

void FrameStream::OnReadDone(bool ok) {
  bool first = false;
  {
    MutexLock lock(&mutex_);
    first = !std::exchange(first_seen_, true);
    if (ending_ != nullptr) return;
    // The session has its own reason to end the stream with.
    if (!ok && session_ != nullptr && session_->ending()) return;
  }
  if (!ok) {
    // A lost link and a client that closes its side look alike from here.
    End(Unexpected("the stream was closed without an end message"));
  } else if (first) {
    HandleFirst();
  } else {
    HandleLater();
  }
}

void FrameStream::HandleFirst() {
  if (!request_.has_hello() && !request_.has_resume()) {
    End(Unexpected("a stream begins with hello or resume"));
    return;
  }
  if (const absl::Status admitted = runner_.Admit(); !admitted.ok()) {
    End(admitted);
    return;
  }
  {
    MutexLock lock(&mutex_);
    opening_ = true;
  }
  runner_.Run([self = shared_from_this()] { self->OpenAndRead(); });
}

void FrameStream::OpenAndRead() {
  absl::Status status = Open();
  runner_.Release();
  request_.Clear();
  if (status.ok()) {
    StartRead(&request_);
  } else {
    End(std::move(status));
  }
  {
    MutexLock lock(&mutex_);
    opening_ = false;
  }
  Pump();
}

absl::Status FrameStream::Open() {
  SessionRegistry& sessions = *runner_.context().sessions;
  SessionRegistry::Opened opened;
  uint64_t last_answered = 0;
  if (request_.has_hello()) {
    SEMMAP_ASSIGN_OR_RETURN(opened, sessions.Open(request_.hello()));
  } else {
    SEMMAP_ASSIGN_OR_RETURN(opened.session, sessions.Resume(request_.resume()));
    opened.resumed = true;
    last_answered = request_.resume().last_answered_sequence();
  }
  auto started = opened.session->Attach(shared_from_this(), opened.resumed, last_answered);
  if (!started.has_value()) return Error(v1::ERROR_REASON_SESSION_NOT_RESUMABLE, "the session is over");
  MutexLock lock(&mutex_);
  session_ = opened.session;
  started_ = std::make_unique<v1::SessionStarted>(std::move(*started));
  return absl::OkStatus();
}

void FrameStream::HandleLater() {
  std::shared_ptr<VehicleSession> session;
  {
    MutexLock lock(&mutex_);
    session = session_;
  }
  if (request_.has_frame()) {
    session->Push(this, std::move(*request_.mutable_frame()));
  } else if (request_.has_end()) {
    // Nothing is to follow; the stream ends when the session is over.
    session->End(v1::SESSION_END_REASON_CLIENT, absl::OkStatus());
    return;
  } else {
    session->End(v1::SESSION_END_REASON_BAD_REQUEST, Unexpected("only frames and the end may follow"));
    return;
  }
  request_.Clear();
  StartRead(&request_);
}

// --- Writing

void FrameStream::End(absl::Status status) {
  {
    MutexLock lock(&mutex_);
    // The first reason counts; that a write failed is still to be acted upon.
    if (ending_ == nullptr) ending_ = std::make_unique<absl::Status>(std::move(status));
  }
  Pump();
}

void FrameStream::Wake() { Pump(); }

bool FrameStream::ChooseWrite() {
  response_.Clear();
  if (started_ != nullptr) {
    *response_.mutable_started() = std::move(*started_);
    started_.reset();
    return true;
  }
  if (session_ == nullptr) return false;
  absl::Status status;
  switch (session_->NextResponse(this, &response_, &status)) {
    case VehicleSession::Next::kMessage:
      return true;
    case VehicleSession::Next::kNothing:
      return false;
    case VehicleSession::Next::kEnd:
      ending_ = std::make_unique<absl::Status>(std::move(status));
      return false;
  }
  return false;
}

void FrameStream::Pump() {
  bool write = false;
  grpc::Status status;
  {
    MutexLock lock(&mutex_);
    if (writing_ || finished_) return;
    if (ending_ == nullptr) write = ChooseWrite();
    if (!write && (ending_ == nullptr || opening_)) return;
    writing_ = write;
    finished_ = !write;
    if (finished_) status = ToGrpc(*ending_);
  }
  // Outside the lock, because gRPC may call back from within. No second write or Finish can come between: the
  // flags are set.
  if (write) {
    StartWrite(&response_);
  } else {
    Finish(status);
  }
}

void FrameStream::OnWriteDone(bool ok) {
  {
    MutexLock lock(&mutex_);
    writing_ = false;
  }
  if (ok) {
    Pump();
  } else {
    End(absl::CancelledError("the stream is gone"));
  }
}

void FrameStream::OnCancel() { End(absl::CancelledError("the stream is gone")); }

void FrameStream::OnDone() {
  std::shared_ptr<VehicleSession> session;
  {
    MutexLock lock(&mutex_);
    session = session_;
  }
  if (session != nullptr) runner_.context().sessions->OnStreamBroken(session, this);
  // The last reference may be this one: nothing may follow.
  const std::shared_ptr<FrameStream> self = std::move(self_);
}

}  // namespace semmap::server
