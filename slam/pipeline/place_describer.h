#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "slam/features/frame_features.h"
#include "slam/place/place_description.h"
#include "slam/place/vocabulary.h"
#include "slam/semantics/taxonomy.h"

namespace semmap {

// Says by a vocabulary what an image shows. Immutable and thread-safe.
class PlaceDescriber {
 public:
  // `vocabulary` is not null. Keypoints of the classes in `inactive` say nothing about a place.
  PlaceDescriber(std::shared_ptr<const Vocabulary> vocabulary, const ClassSet& inactive);

  PlaceDescription Describe(const FrameFeatures& features) const;
  // The words alone, ascending, one for each keypoint that says something: what to keep of a keyframe in
  // order to have its bag without its features.
  std::vector<WordId> WordsOf(const FrameFeatures& features) const;
  BagOfWords BagOf(const std::vector<WordId>& words) const { return vocabulary_->Weigh(words); }

  // Equal where equal features give equal words.
  uint64_t fingerprint() const { return fingerprint_; }
  const std::shared_ptr<const Vocabulary>& vocabulary() const { return vocabulary_; }

 private:
  std::vector<uint32_t> TellingKeypoints(const FrameFeatures& features) const;

  std::shared_ptr<const Vocabulary> vocabulary_;
  ClassSet inactive_;
  uint64_t fingerprint_;
};

}  // namespace semmap
