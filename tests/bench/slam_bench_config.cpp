#include "tests/bench/slam_bench_config.h"

#include <optional>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "slam/common/config_reader.h"
#include "slam/common/status_macros.h"
#include "yaml-cpp/yaml.h"

namespace semmap::bench {
namespace {

absl::StatusOr<YAML::Node> Parse(const std::string& text) {
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(text, ": ", error.what()));
  }
}

absl::StatusOr<YAML::Node> ReadFile(const std::string& path) {
  if (path.empty()) return YAML::Node(YAML::NodeType::Map);
  try {
    return YAML::LoadFile(path);
  } catch (const YAML::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(path, ": ", error.what()));
  }
}

absl::Status Apply(const std::string& setting, YAML::Node root) {
  const size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    return absl::InvalidArgumentError(absl::StrCat(setting, ": is not SETTING=VALUE"));
  SEMMAP_ASSIGN_OR_RETURN(const YAML::Node value, Parse(setting.substr(equals + 1)));
  YAML::Node node = root;
  const std::vector<std::string> keys = absl::StrSplit(setting.substr(0, equals), '.');
  for (size_t i = 0; i + 1 < keys.size(); ++i) {
    if (!node[keys[i]].IsDefined() || node[keys[i]].IsNull()) node[keys[i]] = YAML::Node(YAML::NodeType::Map);
    if (!node[keys[i]].IsMap())
      return absl::InvalidArgumentError(absl::StrCat(setting, ": ", keys[i], " has no settings below it"));
    node.reset(node[keys[i]]);
  }
  node[keys.back()] = value;
  return absl::OkStatus();
}

}  // namespace

absl::StatusOr<SlamConfig> ReadSlamConfig(const std::string& path, const std::vector<std::string>& settings) {
  // The file itself, so that complaints name its lines.
  if (settings.empty()) return path.empty() ? SlamConfig() : SlamConfig::FromFile(path);
  SEMMAP_ASSIGN_OR_RETURN(YAML::Node root, ReadFile(path));
  for (const std::string& setting : settings) SEMMAP_RETURN_IF_ERROR(Apply(setting, root));
  SEMMAP_ASSIGN_OR_RETURN(ConfigReader reader,
                          ConfigReader::FromText(YAML::Dump(root), path.empty() ? "--set" : path));
  SlamConfig config;
  reader.Section("slam", &config);
  reader.Ignore("server");
  reader.Ignore("storage");
  SEMMAP_RETURN_IF_ERROR(reader.Finish());
  return config;
}

}  // namespace semmap::bench
