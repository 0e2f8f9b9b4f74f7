#include "slam/pipeline/own_piece.h"

namespace semmap {
namespace {

// Fewer show nothing that the vehicle will not see again.
constexpr size_t kMinKeyFrames = 5;
// Keyframes that the vehicle adds to the map before its piece is tried again; doubled each time.
constexpr int kFirstPatience = 3;
// So often it is tried to get more to join it by than the one frame that was found.
constexpr int kTriesForMore = 2;

}  // namespace

std::shared_ptr<const MapPiece> OwnPiece::Take() {
  seat_->WaitForBacklog(0);
  auto piece = std::make_shared<const MapPiece>(queue_->TakePiece(*seat_));
  seat_.reset();
  queue_.reset();
  return piece->map.keyframes().size() < kMinKeyFrames ? nullptr : piece;
}

void PieceHandover::Take() {
  piece_ = left_->Take();
  left_.reset();
  patience_ = kFirstPatience;
  if (piece_ == nullptr) map_.NotePiece(0);
}

void PieceHandover::Try(bool trust_found) {
  map_.Join({piece_, ids_, std::nullopt, trust_found});
  ++tries_;
  keyframes_ = 0;
}

void PieceHandover::OnFrame(bool is_keyframe) {
  if (is_keyframe) ++keyframes_;
  if (left_ && left_->IsQuiet()) {
    Take();
    if (piece_ != nullptr) Try(false);
    return;
  }
  if (piece_ == nullptr) return;
  const MapperQueue::Counts counts = map_.counts();
  if (counts.joined_pieces > 0) {
    piece_.reset();
  } else if (counts.refused_pieces == tries_ && keyframes_ >= patience_) {
    patience_ *= 2;
    Try(tries_ >= kTriesForMore);
  }
}

void PieceHandover::Finish() {
  if (left_) Take();
  map_.WaitForBacklog(0);
  if (piece_ != nullptr && map_.counts().joined_pieces == 0) {
    Try(true);
    map_.WaitForBacklog(0);
  }
  map_.NotePiece(0);
}

}  // namespace semmap
