#include "server/rpc/import_call.h"

#include <utility>

#include "absl/time/time.h"
#include "server/error_reasons.h"
#include "server/rpc/grpc_status.h"
#include "slam/common/status_macros.h"

namespace semmap::server {

ImportCall* ImportCall::Start(CallRunner& runner, grpc::CallbackServerContext* call,
                              v1::Operation* response) {
  const std::shared_ptr<ImportCall> import(new ImportCall(runner, call, response));
  import->self_ = import;
  import->Begin();
  return import.get();
}

void ImportCall::Begin() {
  const absl::Status admitted = runner_.Admit();
  admitted_ = admitted.ok();
  if (!admitted_) {
    Finish(ToGrpc(admitted));
    return;
  }
  WatchSilence(0);
  ReadNext();
}

void ImportCall::ReadNext() {
  {
    MutexLock lock(&mutex_);
    ++reads_;
    reading_ = true;
  }
  StartRead(&request_);
}

void ImportCall::WatchSilence(uint64_t reads) {
  const ServiceContext& context = runner_.context();
  context.timer->After(absl::Seconds(context.config.keepalive_s), [weak = weak_from_this(), reads] {
    if (const auto self = weak.lock()) self->EndIfSilentSince(reads);
  });
}

// The call is there until OnDone, which waits for the lock.
void ImportCall::EndIfSilentSince(uint64_t reads) {
  uint64_t now = 0;
  {
    MutexLock lock(&mutex_);
    if (over_) return;
    now = reads_;
    if (reading_ && now == reads) {
      call_->TryCancel();
      return;
    }
  }
  WatchSilence(now);
}

void ImportCall::OnReadDone(bool ok) {
  {
    MutexLock lock(&mutex_);
    reading_ = false;
  }
  if (!ok && call_->IsCancelled()) {
    Finish(grpc::Status::CANCELLED);
    return;
  }
  runner_.Run([this, ok] {
    const absl::Status status = ok ? Take() : Complete();
    if (ok && status.ok()) {
      ReadNext();
    } else {
      Finish(ToGrpc(status));
    }
  });
}

absl::Status ImportCall::Take() {
  if (upload_ != nullptr) {
    if (request_.has_chunk()) return upload_->Append(request_.chunk());
    return Error(v1::ERROR_REASON_MESSAGE_UNEXPECTED, "behind the header only chunks may come");
  }
  if (!request_.has_header()) {
    return Error(v1::ERROR_REASON_MESSAGE_UNEXPECTED, "the first message must be the header");
  }
  SEMMAP_ASSIGN_OR_RETURN(upload_, MapUpload::Begin(runner_.context(), request_.header()));
  return absl::OkStatus();
}

absl::Status ImportCall::Complete() {
  if (upload_ == nullptr) return Error(v1::ERROR_REASON_MESSAGE_UNEXPECTED, "there was no header");
  SEMMAP_ASSIGN_OR_RETURN(*response_, upload_->Finish());
  return absl::OkStatus();
}

void ImportCall::OnDone() {
  {
    MutexLock lock(&mutex_);
    over_ = true;
  }
  if (admitted_) runner_.Release();
  self_.reset();
}

}  // namespace semmap::server
