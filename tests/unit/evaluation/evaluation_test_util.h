#pragma once

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slam/evaluation/association.h"

namespace semmap {

// The folder of shared data, or empty when it is not there.
inline std::string SharedDataFolder() {
  const char* shared = std::getenv("SEMMAP_SHARED");
  const std::filesystem::path folder =
      (shared != nullptr ? std::filesystem::path(shared)
                         : std::filesystem::path(SEMMAP_SOURCE_DIR) / ".." / "shared") /
      "data";
  return std::filesystem::is_directory(folder) ? folder.string() : std::string();
}

// Writes a file that lives as long as the test run's temporary folder. Each test has files of its own: tests
// run beside each other.
inline std::string WriteTemp(const std::string& name, const std::string& text) {
  const ::testing::TestInfo& test = *::testing::UnitTest::GetInstance()->current_test_info();
  std::string file =
      std::string("semmap_evaluation_") + test.test_suite_name() + "_" + test.name() + "_" + name;
  // Names of parameterized tests have slashes.
  std::replace(file.begin(), file.end(), '/', '_');
  const std::string path = ::testing::TempDir() + file;
  std::ofstream(path, std::ios::binary) << text;
  return path;
}

// A bend through space, one pose every 0.1 s and about one metre.
inline Trajectory BendTrajectory(size_t count) {
  Trajectory trajectory;
  for (size_t i = 0; i < count; ++i) {
    const double s = 0.02 * static_cast<double>(i);
    const Eigen::AngleAxisd yaw(s, Eigen::Vector3d::UnitY());
    trajectory.poses.push_back(
        {static_cast<TimestampNs>(i) * 100'000'000,
         SE3(Eigen::Quaterniond(yaw), {50 * (1 - std::cos(s)), 0.5 * std::sin(3 * s), 50 * std::sin(s)})});
  }
  return trajectory;
}

inline std::vector<PosePair> PairUp(const Trajectory& reference, const Trajectory& estimate) {
  return AssociateByIndex(reference, estimate).value();
}

}  // namespace semmap
