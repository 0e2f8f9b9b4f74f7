#include "slam/pipeline/relocalizer.h"

#include <algorithm>

#include "slam/pipeline/keyframe_matcher.h"

namespace semmap {
namespace {

// One search: tries candidates and remembers how far the best of them came.
class Search {
 public:
  Search(const Map& map, const MappingCamera& camera, const ViewLocalizerOptions& options,
         const SearchImage& image, uint64_t version)
      : map_(map), camera_(camera), options_(options), image_(image), version_(version) {}

  // True when the image was found.
  bool Try(KeyFrameId candidate, const DirectIndex& candidate_nodes, const DirectIndex& image_nodes) {
    const KeyFrame* keyframe = map_.FindKeyFrame(candidate);
    return keyframe != nullptr &&
           Locate(candidate, MatchWithinNodes(camera_.association, map_, *keyframe, candidate_nodes,
                                              image_.features, image_nodes));
  }
  bool TryExhaustively(KeyFrameId candidate) {
    const KeyFrame* keyframe = map_.FindKeyFrame(candidate);
    return keyframe != nullptr &&
           Locate(candidate, MatchExhaustively(camera_.association, map_, *keyframe, image_.features));
  }

  Relocalization TakeResult() { return std::move(result_); }

 private:
  bool Locate(KeyFrameId candidate, const std::vector<KeypointPair>& pairs) {
    const auto count = static_cast<int>(pairs.size());
    result_.matches = std::max(result_.matches, count);
    if (count < options_.min_matches) {
      result_.failure = std::max(result_.failure, LocalizationFailure::kTooFewMatches);
      return false;
    }
    const auto view = MakeLocalMapView(map_, candidate, version_, LocalMapViewLimits());
    ViewLocalization located =
        LocateInView(options_, camera_, map_.scale_info(), *view, view->reference(), pairs, image_);
    result_.inliers = std::max(result_.inliers, located.agreement.inliers);
    if (!located.fix) {
      result_.failure = std::max(result_.failure, located.failure);
      return false;
    }
    result_.view = view;
    result_.fix = std::move(located.fix);
    result_.failure = LocalizationFailure::kNone;
    return true;
  }

  const Map& map_;
  const MappingCamera& camera_;
  const ViewLocalizerOptions& options_;
  const SearchImage& image_;
  uint64_t version_;
  Relocalization result_;
};

}  // namespace

Relocalization Relocalizer::Relocalize(const Map& map, const PlaceMemory& places, const MappingCamera& camera,
                                       const SearchImage& image, uint64_t version) const {
  ViewLocalizerOptions options;
  options.limits = config_.limits;
  options.seed = seed_;
  Search search(map, camera, options, image, version);
  if (!places.enabled()) return search.TakeResult();
  const PlaceDescription description = places.Describe(image.features);
  const std::vector<PlaceMatch> candidates =
      places.index().Query(description.words, static_cast<size_t>(config_.candidates));
  bool found = false;
  for (const PlaceMatch& candidate : candidates) {
    found = search.Try(candidate.keyframe, *places.NodesOf(candidate.keyframe), description.nodes);
    if (found) break;
  }
  // Seen from elsewhere, corners change their words before they change their neighbours.
  const size_t exhaustive = std::min(candidates.size(), static_cast<size_t>(config_.exhaustive_candidates));
  for (size_t i = 0; i < exhaustive && !found; ++i) found = search.TryExhaustively(candidates[i].keyframe);
  Relocalization result = search.TakeResult();
  result.candidates = static_cast<int>(candidates.size());
  return result;
}

}  // namespace semmap
