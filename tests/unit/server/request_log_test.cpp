#include "server/request_log.h"

#include <gtest/gtest.h>

namespace semmap::server {
namespace {

TEST(RequestLog, RemembersByMethodAndId) {
  RequestLog log;
  log.Remember("CreateMap", "a", "first");
  log.Remember("CreateMap", "a", "second");
  EXPECT_EQ(log.Find("CreateMap", "a"), "first");
  EXPECT_FALSE(log.Find("DeleteMap", "a").has_value());
  log.Remember("CreateMap", "", "nameless");
  EXPECT_FALSE(log.Find("CreateMap", "").has_value());
}

TEST(RequestLog, ForgetsTheOldest) {
  RequestLog log;
  for (int i = 0; i <= 1000; ++i) log.Remember("CreateMap", std::to_string(i), "x");
  EXPECT_FALSE(log.Find("CreateMap", "0").has_value());
  EXPECT_TRUE(log.Find("CreateMap", "1").has_value());
  EXPECT_TRUE(log.Find("CreateMap", "1000").has_value());
}

}  // namespace
}  // namespace semmap::server
