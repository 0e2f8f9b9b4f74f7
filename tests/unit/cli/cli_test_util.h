#pragma once

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "client/cli/commands.h"
#include "slam/evaluation/trajectory.h"

namespace semmap::client {

// The folder of shared data, or empty when it is not there.
inline std::string SharedDataFolder() {
  const char* shared = std::getenv("SEMMAP_SHARED");
  const std::filesystem::path folder =
      (shared != nullptr ? std::filesystem::path(shared)
                         : std::filesystem::path(SEMMAP_SOURCE_DIR) / ".." / "shared") /
      "data";
  return std::filesystem::is_directory(folder) ? folder.string() : std::string();
}

// What a run of the program left behind.
struct Outcome {
  int exit_code = 0;
  std::string out;
  std::string err;
};

inline Outcome RunProgram(const std::vector<std::string>& arguments) {
  std::ostringstream out;
  std::ostringstream err;
  const int exit_code = RunCommandLine(arguments, Console{out, err, false});
  return {exit_code, out.str(), err.str()};
}

// A folder of its own for each test, removed at the end.
class CliTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    root_ = std::filesystem::path(::testing::TempDir()) /
            (std::string("semmap_") + info->test_suite_name() + "_" + info->name());
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
  }
  void TearDown() override { std::filesystem::remove_all(root_); }

  std::string Path(const std::string& name) const { return (root_ / name).string(); }
  std::string WriteText(const std::string& name, const std::string& text) const {
    std::ofstream(root_ / name, std::ios::binary) << text;
    return Path(name);
  }
  std::string ReadText(const std::string& name) const {
    std::ifstream stream(root_ / name, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  std::filesystem::path root_;
};

// A bend through space, one pose every 0.1 s and about one metre.
inline Trajectory BendTrajectory(size_t count, double scale = 1.0) {
  Trajectory trajectory;
  for (size_t i = 0; i < count; ++i) {
    const double s = 0.02 * static_cast<double>(i);
    const Eigen::AngleAxisd yaw(s, Eigen::Vector3d::UnitY());
    const Eigen::Vector3d position(50 * (1 - std::cos(s)), 0.5 * std::sin(3 * s), 50 * std::sin(s));
    trajectory.poses.push_back(
        {static_cast<TimestampNs>(i) * 100'000'000, SE3(Eigen::Quaterniond(yaw), scale * position)});
  }
  return trajectory;
}

}  // namespace semmap::client
