#pragma once

#include <utility>

#include "handler_fixture.h"
#include "server/handlers/operation_handlers.h"
#include "slam/common/notification.h"

namespace semmap::server {

// For handlers that start operations.
class OperationTest : public HandlerTest {
 protected:
  // The operation when it is done.
  v1::Operation Finished(const absl::StatusOr<v1::Operation>& started) {
    EXPECT_TRUE(started.ok()) << started.status();
    if (!started.ok()) return {};
    v1::WaitOperationRequest request;
    request.set_name(started->name());
    absl::StatusOr<v1::Operation> result = absl::InternalError("not called");
    Notification done;
    WaitOperation(context_, request, [&](absl::StatusOr<v1::Operation> operation) {
      result = std::move(operation);
      done.Notify();
    });
    EXPECT_TRUE(done.WaitForNotificationWithTimeout(absl::Seconds(20)));
    EXPECT_TRUE(result.ok()) << result.status();
    return result.ok() ? *result : v1::Operation();
  }
};

}  // namespace semmap::server
