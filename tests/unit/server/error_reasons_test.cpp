#include "server/error_reasons.h"

#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "google/rpc/error_details.pb.h"

namespace semmap::server {
namespace {

TEST(ErrorReasons, EveryReasonOfTheContractIsInTheTable) {
  const auto* descriptor = v1::ErrorReason_descriptor();
  for (int i = 0; i < descriptor->value_count(); ++i) {
    const auto reason = static_cast<v1::ErrorReason>(descriptor->value(i)->number());
    if (reason == v1::ERROR_REASON_UNSPECIFIED) continue;
    EXPECT_NE(CodeOf(reason), absl::StatusCode::kUnknown) << descriptor->value(i)->name();
  }
}

// The contract states the status code of each reason at the beginning of its comment.
TEST(ErrorReasons, CodesAreThoseThatTheContractStates) {
  std::ifstream proto(std::string(SEMMAP_SOURCE_DIR) + "/proto/semmap/v1/error_reason.proto");
  ASSERT_TRUE(proto.good());
  std::string code;
  int reasons = 0;
  for (std::string line; std::getline(proto, line);) {
    std::istringstream words(line);
    std::string first;
    std::string second;
    words >> first >> second;
    if (first == "//" && code.empty() && second.ends_with('.')) code = second.substr(0, second.size() - 1);
    v1::ErrorReason reason = v1::ERROR_REASON_UNSPECIFIED;
    if (!v1::ErrorReason_Parse(first, &reason) || reason == v1::ERROR_REASON_UNSPECIFIED) continue;
    EXPECT_EQ(absl::StatusCodeToString(CodeOf(reason)), code) << first;
    code.clear();
    ++reasons;
  }
  EXPECT_EQ(reasons, v1::ErrorReason_descriptor()->value_count() - 1);
}

TEST(ErrorReasons, AnErrorCarriesReasonDomainAndMetadata) {
  const absl::Status status = Error(v1::ERROR_REASON_MAP_NOT_FOUND, "no such map", {{"map", "town"}});
  EXPECT_EQ(status.code(), absl::StatusCode::kNotFound);
  EXPECT_EQ(ReasonOf(status), v1::ERROR_REASON_MAP_NOT_FOUND);
  google::rpc::ErrorInfo info;
  ASSERT_TRUE(info.ParseFromString(std::string(*status.GetPayload(kErrorInfoUrl.data()))));
  EXPECT_EQ(info.reason(), "MAP_NOT_FOUND");
  EXPECT_EQ(info.domain(), "semmap");
  EXPECT_EQ(info.metadata().at("map"), "town");
}

TEST(ErrorReasons, AReasonThatIsThereStays) {
  const absl::Status first = Error(v1::ERROR_REASON_RIG_INVALID, "bad");
  EXPECT_EQ(ReasonOf(WithReason(first, v1::ERROR_REASON_INTERNAL)), v1::ERROR_REASON_RIG_INVALID);
  EXPECT_TRUE(WithReason(absl::OkStatus(), v1::ERROR_REASON_INTERNAL).ok());
}

TEST(ErrorReasons, StoreCodesBecomeReasons) {
  EXPECT_EQ(ReasonOf(FromStore(absl::UnavailableError("locked"))), v1::ERROR_REASON_STORE_UNAVAILABLE);
  EXPECT_EQ(ReasonOf(FromStore(absl::DataLossError("damaged"))), v1::ERROR_REASON_STORE_CORRUPT);
  EXPECT_EQ(ReasonOf(FromStore(absl::InternalError("odd"))), v1::ERROR_REASON_INTERNAL);
}

}  // namespace
}  // namespace semmap::server
