#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "client/client.h"
#include "vehicle.h"

namespace semmap::kill_test {

// What was looked at after kills, and what was there.
struct Tally {
  int kills = 0;
  int inside = 0;  // before what was to be killed had ended by itself
  int maps = 0;    // that opened and had no finding
  int empty = 0;   // of them: killed before anything was acknowledged
  int frames = 0;  // acknowledged, and there
  int keyframes = 0;
  int culled = 0;  // of `keyframes`: gone as redundant, its frame is there
  int asked = 0;   // acknowledged frames whose images were looked for
  int found = 0;   // at the place that the trajectory says
  int ended = 0;   // sessions found cleanly ended
  std::vector<std::string> failures;

  void Add(const Tally& other);
};

// Looks at a server that was started again on the data of one that was killed.
class Aftermath {
 public:
  Aftermath(const std::string& address, Tally* tally);

  // The map opens and is sound; whether it is there at all.
  bool InspectMap(const std::string& map);
  // Every acknowledged frame and keyframe is in `map`, which may be a copy of the one that was driven in.
  // Images of `pictures` of these frames are found where the trajectory says.
  void InspectContents(const Testimony& told, const std::string& map, int pictures);
  // The session is known as cut off by a crash, and cannot be taken up again.
  void InspectSession(const Testimony& told);
  // All three, of what a vehicle was told.
  void Inspect(const Testimony& told, int pictures);

  Tally* tally() { return tally_; }
  void Fail(const std::string& what) { tally_->failures.push_back(what); }

 private:
  // Positions by sequence.
  using Trajectory = std::map<uint64_t, Eigen::Vector3d>;
  Trajectory ReadTrajectory(const std::string& map, const std::string& session);
  void Relocalize(const Testimony& told, const std::string& map, uint64_t sequence,
                  const Eigen::Vector3d& expected);

  std::shared_ptr<client::Connection> connection_;
  client::Client client_;
  Tally* tally_;
};

}  // namespace semmap::kill_test
