#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "absl/status/status.h"
#include "absl/time/time.h"
#include "aftermath.h"
#include "recording.h"
#include "tests/e2e/server_process.h"
#include "vehicle.h"
#include "work.h"

namespace semmap::kill_test {

// What goes on when the server is killed. Unless it says otherwise a vehicle drives meanwhile.
enum class Phase { kDrive, kExtend, kLoop, kCopy, kImport, kMerge, kBackup, kMigration };
const char* NameOf(Phase phase);
// The order in which kills come, over and over.
inline constexpr std::array kPhases = {Phase::kDrive,  Phase::kExtend, Phase::kLoop,   Phase::kCopy,
                                       Phase::kImport, Phase::kMerge,  Phase::kBackup, Phase::kMigration,
                                       Phase::kDrive,  Phase::kDrive};

struct RoundsOptions {
  std::string directory;  // of the test's own
  std::string config;     // of semmapd
  uint64_t seed = 1;
  int pictures = 3;  // looked for in each map
};

// Kills servers, starts them again on the same data and looks at what is left. A store takes one turn through
// kPhases; then all its maps are looked at once more, and the next one begins empty.
class Rounds {
 public:
  // `street` is driven in; `round` has a loop.
  Rounds(RoundsOptions options, const Recording& street, const Recording& round);
  ~Rounds();

  // Measures undisturbed drives and makes what the kills need.
  absl::Status Prepare();
  // Kills once in the next phase.
  absl::Status KillOnce();
  // The last look at the store in use.
  absl::Status Finish();

  const std::map<Phase, Tally>& tallies() const { return tallies_; }
  const Tally& last_look() const { return last_look_; }

 private:
  // A moment of a drive: some time after the answer to a frame.
  struct Moment {
    size_t answers = 0;
    absl::Duration later;
  };

  double Draw() { return std::uniform_real_distribution<double>(0, 1)(random_); }
  Moment DrawMoment(const Recording& recording, double from, double until);
  absl::Status Start(const std::string& data);
  absl::Status BeginStore();
  absl::StatusOr<Testimony> DriveUndisturbed(const Recording& recording, const std::string& map);
  absl::Status MeasureLoop();
  absl::Status MakeOldDatabase();

  void KillDrive(const Recording& recording, const std::string& map, v1::SessionMode mode,
                 const Moment& moment, Tally* tally);
  absl::Status KillDuringDrive(Tally* tally);
  absl::Status KillDuringExtension(Tally* tally);
  absl::Status KillDuringLoop(Tally* tally);
  absl::Status KillDuringWork(std::unique_ptr<Work> work, Tally* tally);
  absl::Status KillDuringMigration(Tally* tally);
  absl::Status KillIn(Phase phase, Tally* tally);
  // Starts the killed server again.
  absl::Status Restart() { return Start(data_); }

  const RoundsOptions options_;
  const Recording& street_;
  const Recording& round_;
  std::mt19937_64 random_;
  absl::Duration frame_time_;      // of the street, undisturbed
  Moment loop_begins_;             // of the round
  absl::Duration loop_time_;       // from there until the loop is closed and told
  absl::Duration migration_time_;  // of the old database
  Testimony base_;                 // a whole drive, in every store
  std::string base_file_;          // as an export
  std::string data_;               // of the store in use
  std::unique_ptr<ServerProcess> server_;
  std::vector<Testimony> testimonies_;  // of the store in use
  std::optional<size_t> last_drive_;    // which of them is the newest killed drive in `street_`
  int kills_ = 0;
  std::map<Phase, Tally> tallies_;
  Tally last_look_;
};

}  // namespace semmap::kill_test
