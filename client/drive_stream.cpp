#include "client/drive_stream.h"

#include <utility>

#include "absl/time/time.h"
#include "client/grpc_status.h"

namespace semmap::client {

DriveStream::DriveStream(OnMessage on_message, OnEnd on_end)
    : on_message_(std::move(on_message)), on_end_(std::move(on_end)) {}

std::unique_ptr<DriveStream> DriveStream::Open(v1::SessionService::Stub* stub, OnMessage on_message,
                                               OnEnd on_end) {
  std::unique_ptr<DriveStream> stream(  // NOLINT: the constructor is private
      new DriveStream(std::move(on_message), std::move(on_end)));
  stub->async()->StreamFrames(&stream->context_, stream.get());
  stream->AddHold();
  stream->StartRead(&stream->response_);
  stream->StartCall();
  return stream;
}

bool DriveStream::Write(v1::StreamFramesRequest request, std::chrono::milliseconds timeout) {
  {
    MutexLock lock(&mutex_);
    if (closed_ || writing_) return false;
    writing_ = true;
  }
  request_ = std::move(request);
  StartWrite(&request_);
  MutexLock lock(&mutex_);
  if (!mutex_.AwaitWithTimeout(absl::FromChrono(timeout), &DriveStream::NotWriting, this)) {
    context_.TryCancel();
    mutex_.Await(&DriveStream::NotWriting, this);
  }
  return !closed_;
}

void DriveStream::Cancel() { context_.TryCancel(); }

void DriveStream::OnReadDone(bool ok) {
  if (!ok) {
    Close(false);
    return;
  }
  on_message_(response_);
  response_.Clear();
  StartRead(&response_);
}

void DriveStream::OnWriteDone(bool ok) {
  if (!ok) {
    Close(true);
    return;
  }
  bool closed = false;
  {
    MutexLock lock(&mutex_);
    closed = closed_;
    writing_ = closed;  // Close ends it
  }
  if (closed) Close(true);
}

void DriveStream::Close(bool write_is_over) {
  bool release = false;
  {
    MutexLock lock(&mutex_);
    closed_ = true;
    if (write_is_over) writing_ = false;
    release = !writing_ && held_;
    if (release) held_ = false;
  }
  if (release) RemoveHold();
}

void DriveStream::OnDone(const grpc::Status& status) {
  // Whoever is told may destroy this at once.
  const OnEnd on_end = on_end_;
  on_end(FromGrpc(status));
}

}  // namespace semmap::client
