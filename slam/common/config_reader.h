#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "absl/strings/str_cat.h"
#include "yaml-cpp/yaml.h"

namespace semmap {

// Reads one YAML mapping into a struct and remembers every complaint with file and line: wrong types, values
// out of bounds and (at Finish) keys nobody asked for. A struct declares its fields once, beside its
// defaults:
//
//   void OrbConfig::Read(ConfigReader& reader) { reader.Number("levels", &levels, 1, 12); }
//
// A key that is absent leaves the default. A reader without complaints yields OK from Finish(). Not
// thread-safe.
class ConfigReader {
 public:
  // Root of a file; NOT_FOUND when it cannot be read, INVALID_ARGUMENT with the line when it is no YAML
  // mapping.
  static absl::StatusOr<ConfigReader> FromFile(const std::string& path);
  // For tests and defaults; `name` stands for the file in messages.
  static absl::StatusOr<ConfigReader> FromText(const std::string& text, const std::string& name);

  // Integers and floating point numbers within [low, high]; not-a-number is out of every bound.
  void Number(const char* key, int* value, int low, int high);
  void Number(const char* key, int64_t* value, int64_t low, int64_t high);
  void Number(const char* key, double* value, double low, double high);
  void Flag(const char* key, bool* value);
  void Text(const char* key, std::string* value);
  // One of `choices`.
  void Choice(const char* key, std::string* value, const std::vector<std::string>& choices);
  void NumberList(const char* key, std::vector<double>* values, size_t max_size);
  void TextList(const char* key, std::vector<std::string>* values, size_t max_size);

  bool Has(const char* key) const;
  // Whether the key is there and holds a sequence.
  bool HasList(const char* key) const;
  // Marks a key as known without reading it: another program's part of a shared file.
  void Ignore(const char* key);
  // A nested mapping; absent, it reads as empty. Its complaints count as this reader's.
  template <typename Struct>
  void Section(const char* key, Struct* value) {
    ConfigReader child = Child(key);
    value->Read(child);
    Absorb(child);
  }

  // A complaint of the caller's own, for bounds that tie two fields together.
  void Complain(const char* key, std::string_view reason);
  // INVALID_ARGUMENT listing every complaint as "file:line: key: reason", or OK.
  absl::Status Finish();

 private:
  ConfigReader(std::string name, std::string prefix, YAML::Node node);
  ConfigReader Child(const char* key);
  void Absorb(ConfigReader& child);
  YAML::Node Find(const char* key);
  template <typename T>
  void ReadBounded(const char* key, T* value, T low, T high);
  void ComplainUnknownKeys();

  std::string name_;
  std::string prefix_;
  YAML::Node node_;
  std::vector<std::string> known_;
  std::vector<std::string> complaints_;
};

}  // namespace semmap
