#include "work.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <span>

#include "absl/strings/str_cat.h"
#include "slam/common/mutex.h"
#include "slam/common/status_macros.h"
#include "tests/e2e/server_process.h"

namespace semmap::kill_test {
namespace {

constexpr int kPictures = 1;

// A map is there as a whole, or not at all.
void InspectNewMap(Aftermath* aftermath, const Testimony& base, const std::string& name, bool done) {
  const bool there = aftermath->InspectMap(name);
  if (there) aftermath->InspectContents(base, name, kPictures);
  if (done && !there) aftermath->Fail(absl::StrCat(name, " was made and is gone"));
}

class Copy : public Work {
 public:
  explicit Copy(const Testimony& base) : base_(base) {}
  absl::Status Run(client::Client& client, const std::string& name) override {
    return client.CopyMap(base_.map, name, nullptr).status();
  }
  absl::Status Undo(client::Client& client, const std::string& name) override {
    return client.DeleteMap(name);
  }
  void Inspect(Aftermath* aftermath, const std::string& name, bool done) override {
    InspectNewMap(aftermath, base_, name, done);
  }

 private:
  const Testimony& base_;
};

class Import : public Work {
 public:
  Import(const Testimony& base, const std::string& file) : base_(base), file_(file) {}
  absl::Status Run(client::Client& client, const std::string& name) override {
    size_t sent = 0;
    const auto read = [&](std::span<char> room) -> absl::StatusOr<size_t> {
      const size_t count = file_.copy(room.data(), room.size(), sent);
      sent += count;
      return count;
    };
    return client.ImportMap(name, "", read, nullptr).status();
  }
  absl::Status Undo(client::Client& client, const std::string& name) override {
    return client.DeleteMap(name);
  }
  void Inspect(Aftermath* aftermath, const std::string& name, bool done) override {
    InspectNewMap(aftermath, base_, name, done);
  }

 private:
  const Testimony& base_;
  const std::string& file_;
};

class Merge : public Work {
 public:
  explicit Merge(const Testimony& base) : base_(base) {}
  absl::Status Prepare(client::Client& client, const std::string& name) override {
    SEMMAP_RETURN_IF_ERROR(client.CopyMap(base_.map, name, nullptr).status());
    return client.CopyMap(base_.map, SourceOf(name), nullptr).status();
  }
  absl::Status Run(client::Client& client, const std::string& name) override {
    v1::MergeMapsRequest request;
    request.set_target(name);
    request.set_source(SourceOf(name));
    return client.MergeMaps(request, nullptr).status();
  }
  absl::Status Undo(client::Client& client, const std::string& name) override {
    SEMMAP_RETURN_IF_ERROR(client.DeleteMap(name));
    return client.DeleteMap(SourceOf(name));
  }
  // Both maps are there, and have what they had, joined or not.
  void Inspect(Aftermath* aftermath, const std::string& name, bool /*done*/) override {
    for (const std::string& map : {name, SourceOf(name)}) {
      if (!aftermath->InspectMap(map)) aftermath->Fail(absl::StrCat(map, " is gone"));
      aftermath->InspectContents(base_, map, kPictures);
    }
  }

 private:
  static std::string SourceOf(const std::string& name) { return name + "-source"; }

  const Testimony& base_;
};

class Backup : public Work {
 public:
  Backup(const Testimony& base, const std::string& config, const std::string& data)
      : base_(base), config_(config), data_(data) {}

  absl::Status Run(client::Client& /*client*/, const std::string& name) override {
    DaemonProcess* process = nullptr;
    {
      MutexLock lock(&mutex_);
      process_ = std::make_unique<DaemonProcess>(
          std::vector<std::string>{"--config", config_, "--data", data_, "--backup", FileOf(name)},
          data_ + "/backup.log");
      process = process_.get();
    }
    // Its one line says that the file is complete.
    if (process->ReadLine().empty()) return absl::AbortedError("no backup");
    return absl::OkStatus();
  }
  absl::Status Undo(client::Client& /*client*/, const std::string& name) override {
    std::filesystem::remove(FileOf(name));
    return absl::OkStatus();
  }
  void Kill() override {
    MutexLock lock(&mutex_);
    if (process_ != nullptr) process_->Stop(SIGKILL);
  }

  // The file is not there, or it opens as a database of all maps.
  void Inspect(Aftermath* aftermath, const std::string& name, bool done) override {
    MutexLock lock(&mutex_);
    process_.reset();
    if (!std::filesystem::exists(FileOf(name))) {
      if (done) aftermath->Fail(absl::StrCat(FileOf(name), " was written and is gone"));
      return;
    }
    const std::string other = data_ + "/" + name;
    std::filesystem::create_directory(other);
    std::filesystem::copy_file(FileOf(name), other + "/semmap.db");
    ServerProcess server(config_, other);
    if (server.address().empty()) {
      aftermath->Fail(absl::StrCat(FileOf(name), " does not open"));
      return;
    }
    Aftermath inside(server.address(), aftermath->tally());
    if (!inside.InspectMap(base_.map)) aftermath->Fail(absl::StrCat(base_.map, " is not in ", FileOf(name)));
    inside.InspectContents(base_, base_.map, kPictures);
    server.Stop(SIGKILL);
    std::filesystem::remove_all(other);
    std::filesystem::remove(FileOf(name));
  }

 private:
  std::string FileOf(const std::string& name) const { return data_ + "/" + name + ".db"; }

  const Testimony& base_;
  const std::string config_;
  const std::string data_;
  Mutex mutex_;  // guards process_
  std::unique_ptr<DaemonProcess> process_ ABSL_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<Work> CopyWork(const Testimony& base) { return std::make_unique<Copy>(base); }

std::unique_ptr<Work> ImportWork(const Testimony& base, const std::string& file) {
  return std::make_unique<Import>(base, file);
}

std::unique_ptr<Work> MergeWork(const Testimony& base) { return std::make_unique<Merge>(base); }

std::unique_ptr<Work> BackupWork(const Testimony& base, const std::string& config, const std::string& data) {
  return std::make_unique<Backup>(base, config, data);
}

}  // namespace semmap::kill_test
