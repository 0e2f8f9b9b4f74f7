#include "client/cli/point_filter_options.h"

#include "absl/strings/str_cat.h"
#include "client/cli/class_names.h"
#include "client/cli/console.h"

namespace semmap::client {

void AddPointFilterOptions(CLI::App& command, PointFilterOptions* options) {
  AddAreaOptions(command, &options->area);
  command.add_option("--class", options->classes, "Only of this class (name or number); repeatable");
  command.add_option("--min-observations", options->min_observations, "Only seen by so many keyframes")
      ->check(CLI::NonNegativeNumber);
  command
      .add_option("--min-confidence", options->min_confidence,
                  "Only where the class has this share of the votes, 0 to 1")
      ->check(CLI::Range(0.0, 1.0));
  command.add_option("--seen-from", options->seen_from_ns,
                     "Only seen at this vehicle time or later, nanoseconds");
  command.add_option("--seen-until", options->seen_until_ns,
                     "Only seen before this vehicle time, nanoseconds");
  command.add_flag("--active", options->active_only, "Only of classes that stay where they are");
}

absl::StatusOr<v1::MapPointFilter> FilterOf(const PointFilterOptions& options) {
  v1::MapPointFilter filter;
  v1::Area area;
  if (FillArea(options.area, &area)) *filter.mutable_area() = area;
  for (const std::string& name : options.classes) {
    const std::optional<uint32_t> id = ParseClass(name);
    if (!id) return UsageError(absl::StrCat("--class ", name, ": no such class"));
    filter.add_semantic_classes(*id);
  }
  filter.set_min_observations(options.min_observations);
  filter.set_min_class_confidence(options.min_confidence);
  if (options.seen_from_ns) filter.mutable_seen()->set_start_ns(*options.seen_from_ns);
  if (options.seen_until_ns) filter.mutable_seen()->set_end_ns(*options.seen_until_ns);
  filter.set_active_only(options.active_only);
  return filter;
}

}  // namespace semmap::client
