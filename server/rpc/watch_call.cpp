#include "server/rpc/watch_call.h"

#include <utility>

#include "server/rpc/grpc_status.h"

namespace semmap::server {

WatchCall* WatchCall::Start(CallRunner& runner, const v1::WatchMapRequest* request) {
  const std::shared_ptr<WatchCall> watch(new WatchCall(runner));
  watch->self_ = watch;
  const absl::Status admitted = runner.Admit();
  watch->admitted_ = admitted.ok();
  if (admitted.ok()) {
    // The request stays until Finish.
    runner.Run([watch, request] { watch->Open(*request); });
  } else {
    watch->End(admitted);
  }
  return watch.get();
}

void WatchCall::Open(const v1::WatchMapRequest& request) {
  auto source = WatchSource::Make(runner_.context(), request, [weak = weak_from_this()] {
    if (const auto watch = weak.lock()) watch->Wake();
  });
  if (!source.ok()) {
    End(source.status());
    return;
  }
  source_ = *std::move(source);
  Step();
}

void WatchCall::Wake() {
  {
    MutexLock lock(&mutex_);
    woken_ = true;
    if (busy_ || finished_) return;
    busy_ = true;
  }
  runner_.Run([self = shared_from_this()] { self->Step(); });
}

void WatchCall::Step() {
  while (true) {
    {
      MutexLock lock(&mutex_);
      if (finished_) return;
      woken_ = false;
      if (cancelled_) break;
    }
    message_.Clear();
    const auto told = source_->Next(&message_);
    if (!told.ok()) {
      End(told.status());
      return;
    }
    if (*told) {
      StartWrite(&message_);
      return;
    }
    MutexLock lock(&mutex_);
    if (woken_ || cancelled_) continue;
    busy_ = false;
    return;
  }
  End(absl::CancelledError("the watcher has gone"));
}

void WatchCall::OnWriteDone(bool ok) {
  if (ok) {
    runner_.Run([self = shared_from_this()] { self->Step(); });
  } else {
    End(absl::CancelledError("the watcher has gone"));
  }
}

void WatchCall::OnCancel() {
  {
    MutexLock lock(&mutex_);
    cancelled_ = true;
  }
  Wake();
}

void WatchCall::End(const absl::Status& status) {
  {
    MutexLock lock(&mutex_);
    if (std::exchange(finished_, true)) return;
  }
  Finish(absl::IsCancelled(status) ? grpc::Status::CANCELLED : ToGrpc(status));
}

void WatchCall::OnDone() {
  if (admitted_) runner_.Release();
  self_.reset();
}

}  // namespace semmap::server
