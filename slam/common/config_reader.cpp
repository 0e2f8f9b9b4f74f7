#include "slam/common/config_reader.h"

#include <algorithm>
#include <cmath>

#include "absl/strings/str_join.h"
#include "yaml-cpp/yaml.h"

namespace semmap {
namespace {

absl::Status NotAMapping(const std::string& name) {
  return absl::InvalidArgumentError(absl::StrCat(name, ": expected a mapping of keys to values"));
}

std::string At(const std::string& name, const YAML::Node& node) {
  return absl::StrCat(name, ":", node.Mark().line + 1);
}

}  // namespace

ConfigReader::ConfigReader(std::string name, std::string prefix, YAML::Node node)
    : name_(std::move(name)), prefix_(std::move(prefix)), node_(std::move(node)) {}

absl::StatusOr<ConfigReader> ConfigReader::FromFile(const std::string& path) {
  try {
    YAML::Node node = YAML::LoadFile(path);
    if (!node.IsMap() && !node.IsNull()) return NotAMapping(path);
    return ConfigReader(path, "", std::move(node));
  } catch (const YAML::BadFile&) {
    return absl::NotFoundError(absl::StrCat(path, ": cannot be read"));
  } catch (const YAML::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(path, ":", error.mark.line + 1, ": ", error.msg));
  }
}

absl::StatusOr<ConfigReader> ConfigReader::FromText(const std::string& text, const std::string& name) {
  try {
    YAML::Node node = YAML::Load(text);
    if (!node.IsMap() && !node.IsNull()) return NotAMapping(name);
    return ConfigReader(name, "", std::move(node));
  } catch (const YAML::Exception& error) {
    return absl::InvalidArgumentError(absl::StrCat(name, ":", error.mark.line + 1, ": ", error.msg));
  }
}

YAML::Node ConfigReader::Find(const char* key) {
  known_.emplace_back(key);
  // A const node answers a missing key with an undefined node; a mutable one would create it.
  const YAML::Node& fixed = node_;
  return node_.IsMap() ? fixed[key] : YAML::Node(YAML::NodeType::Undefined);
}

bool ConfigReader::Has(const char* key) const { return node_.IsMap() && node_[key].IsDefined(); }

bool ConfigReader::HasList(const char* key) const { return Has(key) && node_[key].IsSequence(); }

void ConfigReader::Ignore(const char* key) { known_.emplace_back(key); }

template <typename T>
void ConfigReader::ReadBounded(const char* key, T* value, T low, T high) {
  const YAML::Node field = Find(key);
  if (!field.IsDefined()) return;
  T parsed{};
  if (!field.IsScalar() || !YAML::convert<T>::decode(field, parsed)) {
    Complain(key, "is not a number of the right kind");
  } else if (!(parsed >= low && parsed <= high)) {
    Complain(key, absl::StrCat("is ", field.Scalar(), ", must be between ", low, " and ", high));
  } else {
    *value = parsed;
  }
}

void ConfigReader::Number(const char* key, int* value, int low, int high) {
  ReadBounded(key, value, low, high);
}

void ConfigReader::Number(const char* key, int64_t* value, int64_t low, int64_t high) {
  ReadBounded(key, value, low, high);
}

void ConfigReader::Number(const char* key, double* value, double low, double high) {
  ReadBounded(key, value, low, high);
}

void ConfigReader::Flag(const char* key, bool* value) {
  const YAML::Node field = Find(key);
  if (!field.IsDefined()) return;
  if (!field.IsScalar() || !YAML::convert<bool>::decode(field, *value)) Complain(key, "is not true or false");
}

void ConfigReader::Text(const char* key, std::string* value) {
  const YAML::Node field = Find(key);
  if (!field.IsDefined()) return;
  if (!field.IsScalar()) {
    Complain(key, "is not a text");
    return;
  }
  *value = field.Scalar();
}

void ConfigReader::Choice(const char* key, std::string* value, const std::vector<std::string>& choices) {
  std::string chosen = *value;
  Text(key, &chosen);
  if (std::find(choices.begin(), choices.end(), chosen) == choices.end()) {
    Complain(key, absl::StrCat("is '", chosen, "', must be one of ", absl::StrJoin(choices, ", ")));
    return;
  }
  *value = chosen;
}

void ConfigReader::NumberList(const char* key, std::vector<double>* values, size_t max_size) {
  const YAML::Node field = Find(key);
  if (!field.IsDefined()) return;
  std::vector<double> parsed;
  // One by one: the conversion of a whole sequence throws at the first wrong element.
  bool valid = field.IsSequence() && field.size() <= max_size;
  for (size_t i = 0; valid && i < field.size(); ++i) {
    double number = 0;
    valid = field[i].IsScalar() && YAML::convert<double>::decode(field[i], number) && std::isfinite(number);
    parsed.push_back(number);
  }
  if (!valid) {
    Complain(key, absl::StrCat("is not a list of at most ", max_size, " finite numbers"));
    return;
  }
  *values = std::move(parsed);
}

void ConfigReader::TextList(const char* key, std::vector<std::string>* values, size_t max_size) {
  const YAML::Node field = Find(key);
  if (!field.IsDefined()) return;
  std::vector<std::string> parsed;
  bool valid = field.IsSequence() && field.size() <= max_size;
  for (size_t i = 0; valid && i < field.size(); ++i) {
    valid = field[i].IsScalar();
    if (valid) parsed.push_back(field[i].Scalar());
  }
  if (!valid) {
    Complain(key, absl::StrCat("is not a list of at most ", max_size, " texts"));
    return;
  }
  *values = std::move(parsed);
}

ConfigReader ConfigReader::Child(const char* key) {
  const YAML::Node field = Find(key);
  if (field.IsDefined() && !field.IsMap() && !field.IsNull()) Complain(key, "is not a mapping");
  return ConfigReader(name_, absl::StrCat(prefix_, key, "."), field.IsDefined() ? field : YAML::Node());
}

void ConfigReader::Absorb(ConfigReader& child) {
  child.ComplainUnknownKeys();
  complaints_.insert(complaints_.end(), child.complaints_.begin(), child.complaints_.end());
}

void ConfigReader::Complain(const char* key, std::string_view reason) {
  const YAML::Node& fixed = node_;
  const YAML::Node field = node_.IsMap() ? fixed[key] : YAML::Node(YAML::NodeType::Undefined);
  complaints_.push_back(absl::StrCat(At(name_, field.IsDefined() ? field : node_), ": ", prefix_, key, " ",
                                     std::string(reason)));
}

void ConfigReader::ComplainUnknownKeys() {
  if (!node_.IsMap()) return;
  for (const auto& entry : node_) {
    const std::string& key = entry.first.Scalar();
    if (std::find(known_.begin(), known_.end(), key) != known_.end()) continue;
    complaints_.push_back(absl::StrCat(At(name_, entry.first), ": ", prefix_, key, " is not a known key"));
  }
}

absl::Status ConfigReader::Finish() {
  ComplainUnknownKeys();
  if (complaints_.empty()) return absl::OkStatus();
  return absl::InvalidArgumentError(absl::StrJoin(complaints_, "\n"));
}

}  // namespace semmap
