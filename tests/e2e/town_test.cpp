// `semmap town drive` against the real server: a simulated vehicle that streams what it sees.
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "client/cli/commands.h"
#include "client/town/drive.h"
#include "server_process.h"

namespace semmap {
namespace {

class TownE2eTest : public testing::Test {
 protected:
  TownE2eTest() {
    std::string path = (std::filesystem::temp_directory_path() / "semmap-town-e2e-XXXXXX").string();
    data_ = mkdtemp(path.data());
    std::ofstream(data_ + "/rig.yaml") << "width: 480\nheight: 360\n";
  }
  ~TownE2eTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(data_, ignored);
  }
  void SetUp() override {
    const auto renderer = town::TownDrive::Create({});
    if (absl::IsUnavailable(renderer.status())) GTEST_SKIP() << renderer.status();
  }

  // The summary that `semmap town drive` prints; null when it failed.
  nlohmann::json Drive(const std::string& address, std::vector<std::string> more) {
    std::vector<std::string> arguments = {
        "town", "drive", "--server",          address,      "--json", "--route",
        "2",    "--rig", data_ + "/rig.yaml", "--vehicles", "0",      "--pedestrians",
        "0"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    std::ostringstream out;
    std::ostringstream err;
    const int exit_code = client::RunCommandLine(arguments, {out, err, false});
    EXPECT_EQ(exit_code, 0) << err.str();
    return nlohmann::json::parse(out.str(), nullptr, false);
  }

  int CountLines(const std::string& name) const {
    std::ifstream file(data_ + "/" + name);
    int lines = 0;
    for (std::string line; std::getline(file, line);) lines += line.starts_with('#') ? 0 : 1;
    return lines;
  }

  std::string data_;
};

TEST_F(TownE2eTest, StereoVehicleIsTrackedWithinCentimetres) {
  ServerProcess server(std::string(SEMMAP_SOURCE_DIR) + "/config/semmapd.yaml", data_);
  ASSERT_FALSE(server.address().empty());
  const nlohmann::json summary =
      Drive(server.address(), {"--map", "stereo", "--vehicle", "car", "--stereo", "--frames", "60",
                               "--trajectory", data_ + "/stereo.txt", "--truth", data_ + "/truth.txt"});
  ASSERT_TRUE(summary.is_object());
  EXPECT_EQ(summary["frames"], 60);
  EXPECT_EQ(summary["tracked"], 60);
  EXPECT_EQ(summary["vehicle"], "car");
  EXPECT_EQ(summary["ate_poses"], 60);
  EXPECT_EQ(summary["ate_alignment"], "se3");
  EXPECT_LT(summary["ate_rmse_m"].get<double>(), 0.05);
  EXPECT_GT(summary["points"].get<int>(), 500);
  EXPECT_EQ(CountLines("stereo.txt"), CountLines("truth.txt"));
  EXPECT_GE(CountLines("truth.txt"), 60);
}

TEST_F(TownE2eTest, MonocularVehicleSendsJpegAndMasks) {
  ServerProcess server(std::string(SEMMAP_SOURCE_DIR) + "/config/semmapd.yaml", data_);
  ASSERT_FALSE(server.address().empty());
  const nlohmann::json summary =
      Drive(server.address(), {"--map", "mono", "--jpeg", "92", "--grey", "--send-class", "--frames", "90"});
  ASSERT_TRUE(summary.is_object());
  EXPECT_EQ(summary["frames"], 90);
  EXPECT_EQ(summary["vehicle"], "town-2");
  // The vehicle stands at first, and one camera needs motion to start.
  EXPECT_GT(summary["tracked"].get<int>(), 40);
  EXPECT_EQ(summary["ate_alignment"], "sim3");
  EXPECT_LT(summary["ate_rmse_m"].get<double>(), 0.2);
}

}  // namespace
}  // namespace semmap
