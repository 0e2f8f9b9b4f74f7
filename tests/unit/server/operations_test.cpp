#include "server/operations.h"

#include <gtest/gtest.h>

#include "server/error_reasons.h"
#include "slam/common/notification.h"

namespace semmap::server {
namespace {

class OperationsTest : public testing::Test {
 protected:
  // An operation that runs until the test lets it end, or it is cancelled.
  absl::StatusOr<v1::Operation> StartHeld(const std::string& map = "town") {
    return operations_->Start(v1::OPERATION_KIND_CHECK, {map},
                              [this](OperationProgress& progress) { return Hold(progress); });
  }

  Operations::Result Hold(OperationProgress& progress) {
    progress.Report(0.5);
    started_.Notify();
    while (!release_.WaitForNotificationWithTimeout(absl::Milliseconds(5))) {
      if (progress.CancelRequested()) return absl::CancelledError("as asked");
    }
    return std::make_unique<v1::CancelOperationRequest>();
  }

  v1::Operation WaitFor(const std::string& id) {
    v1::Operation result;
    Notification done;
    const absl::Status status = operations_->WhenDone(id, [&](const v1::Operation& operation) {
      result = operation;
      done.Notify();
    });
    EXPECT_TRUE(status.ok()) << status;
    EXPECT_TRUE(done.WaitForNotificationWithTimeout(absl::Seconds(10)));
    return result;
  }

  std::unique_ptr<Executor> threads_ = MakeThreadPool(1);
  Notification started_;
  Notification release_;
  std::unique_ptr<Operations> operations_ =
      std::make_unique<Operations>(threads_.get(), [] { return TimestampNs{5'000'000'000}; });
};

TEST_F(OperationsTest, RunsAndKeepsTheResponse) {
  const auto started = StartHeld();
  ASSERT_TRUE(started.ok()) << started.status();
  EXPECT_EQ(started->name(), "operations/1");
  EXPECT_FALSE(started->done());
  EXPECT_EQ(started->metadata().maps(0), "maps/town");
  EXPECT_EQ(started->metadata().create_time().seconds(), 5);
  started_.WaitForNotification();
  EXPECT_EQ(operations_->Get("1")->metadata().progress(), 0.5);
  release_.Notify();
  const v1::Operation done = WaitFor("1");
  EXPECT_TRUE(done.done());
  EXPECT_TRUE(done.response().Is<v1::CancelOperationRequest>());
  EXPECT_EQ(done.metadata().progress(), 1);
  EXPECT_TRUE(done.metadata().has_end_time());
  EXPECT_TRUE(WaitFor("1").done());  // again: at once
}

TEST_F(OperationsTest, KeepsWhyOneFailed) {
  const auto fail = [](OperationProgress&) -> absl::StatusOr<std::unique_ptr<google::protobuf::Message>> {
    return Error(v1::ERROR_REASON_MAP_EXISTS, "there");
  };
  ASSERT_TRUE(operations_->Start(v1::OPERATION_KIND_COPY, {"town"}, fail).ok());
  const v1::Operation done = WaitFor("1");
  EXPECT_EQ(done.error().code(), static_cast<int>(absl::StatusCode::kAlreadyExists));
  EXPECT_EQ(done.error().details_size(), 1);
}

TEST_F(OperationsTest, CancelledOnesEndWithCancelled) {
  ASSERT_TRUE(StartHeld().ok());
  ASSERT_TRUE(StartHeld().ok());  // waits for the thread
  ASSERT_TRUE(operations_->Cancel("1").ok());
  ASSERT_TRUE(operations_->Cancel("2").ok());
  for (const char* id : {"1", "2"}) {
    const v1::Operation done = WaitFor(id);
    EXPECT_EQ(done.error().code(), static_cast<int>(absl::StatusCode::kCancelled));
    EXPECT_TRUE(done.metadata().cancel_requested());
  }
}

TEST_F(OperationsTest, WhatTheWorkHoldsIsFreeWhenItIsDone) {
  ASSERT_TRUE(StartHeld().ok());
  std::weak_ptr<int> held;
  {
    const auto hold = std::make_shared<int>(0);
    held = hold;
    const auto work = [hold](OperationProgress&) -> Operations::Result { return absl::InternalError("ran"); };
    ASSERT_TRUE(operations_->Start(v1::OPERATION_KIND_MERGE, {"town"}, work).ok());
  }
  ASSERT_TRUE(operations_->Cancel("2").ok());
  bool was_free = false;
  Notification done;
  const auto look = [&](const v1::Operation&) {
    was_free = held.expired();
    done.Notify();
  };
  ASSERT_TRUE(operations_->WhenDone("2", look).ok());
  EXPECT_FALSE(held.expired());
  release_.Notify();
  ASSERT_TRUE(done.WaitForNotificationWithTimeout(absl::Seconds(10)));
  EXPECT_TRUE(was_free);
}

TEST_F(OperationsTest, ListsNewestFirstAndForgets) {
  ASSERT_TRUE(StartHeld("town").ok());
  ASSERT_TRUE(StartHeld("village").ok());
  EXPECT_EQ(operations_->List("").size(), 2U);
  EXPECT_EQ(operations_->List("").front().name(), "operations/2");
  EXPECT_EQ(operations_->List("town").front().name(), "operations/1");
  EXPECT_EQ(ReasonOf(operations_->Forget("1")), v1::ERROR_REASON_FIELD_INVALID);
  release_.Notify();
  WaitFor("1");
  EXPECT_TRUE(operations_->Forget("1").ok());
  for (const char* id : {"1", "3", "x", ""}) {
    EXPECT_EQ(ReasonOf(operations_->Get(id).status()), v1::ERROR_REASON_OPERATION_NOT_FOUND) << id;
    EXPECT_EQ(ReasonOf(operations_->Cancel(id)), v1::ERROR_REASON_OPERATION_NOT_FOUND) << id;
    EXPECT_EQ(ReasonOf(operations_->Forget(id)), v1::ERROR_REASON_OPERATION_NOT_FOUND) << id;
  }
}

TEST_F(OperationsTest, OnlySoManyAtOnce) {
  absl::Status status;
  int started = 0;
  for (; status.ok() && started < 100; ++started) status = StartHeld().status();
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_TOO_MANY_REQUESTS);
  release_.Notify();
}

TEST_F(OperationsTest, StoppingAnswersThoseWhoWait) {
  ASSERT_TRUE(StartHeld().ok());
  started_.WaitForNotification();
  Notification answered;
  ASSERT_TRUE(operations_->WhenDone("1", [&](const v1::Operation&) { answered.Notify(); }).ok());
  operations_->Stop();
  EXPECT_TRUE(answered.HasBeenNotified());
  EXPECT_EQ(ReasonOf(StartHeld().status()), v1::ERROR_REASON_SHUTTING_DOWN);
  operations_.reset();  // the held one is cancelled, or this would not return
}

}  // namespace
}  // namespace semmap::server
