#pragma once

#include <memory>
#include <utility>

#include <grpcpp/grpcpp.h>
#include <grpcpp/support/server_callback.h>

#include "absl/status/statusor.h"
#include "server/handlers/chunk_source.h"
#include "server/rpc/call_runner.h"
#include "server/rpc/grpc_status.h"

namespace semmap::server {

template <typename Request, typename Response>
using SourceMaker = absl::StatusOr<std::unique_ptr<ChunkSource<Response>>> (*)(const ServiceContext&,
                                                                               const Request&);

// Sends a streamed answer piece by piece. The next piece is made when the one before has left: a reader that
// is slow or stopped holds no thread and one piece of memory. Deletes itself when the call is over.
template <typename Request, typename Response>
class StreamedCall : public grpc::ServerWriteReactor<Response> {
 public:
  StreamedCall(CallRunner& runner, grpc::CallbackServerContext* call, const Request* request,
               SourceMaker<Request, Response> maker)
      : runner_(runner), call_(call) {
    const absl::Status admitted = runner_.Admit();
    admitted_ = admitted.ok();
    if (!admitted_) {
      this->Finish(ToGrpc(admitted));
      return;
    }
    runner_.Run([this, request, maker] {
      auto source = maker(runner_.context(), *request);
      if (!source.ok()) {
        this->Finish(ToGrpc(source.status()));
        return;
      }
      source_ = std::move(source).value();
      WriteNext();
    });
  }

  void OnWriteDone(bool ok) override {
    if (!ok || call_->IsCancelled()) {
      this->Finish(grpc::Status::CANCELLED);
      return;
    }
    runner_.Run([this] { WriteNext(); });
  }

  void OnDone() override {
    if (admitted_) runner_.Release();
    delete this;
  }

 private:
  void WriteNext() {
    piece_.Clear();
    const auto more = source_->Next(&piece_);
    if (more.ok() && *more) {
      this->StartWrite(&piece_);
    } else {
      this->Finish(ToGrpc(more.status()));
    }
  }

  CallRunner& runner_;
  grpc::CallbackServerContext* const call_;
  bool admitted_ = false;
  std::unique_ptr<ChunkSource<Response>> source_;
  Response piece_;
};

}  // namespace semmap::server
