#include "storage/sqlite/word_rows.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "slam/common/status_macros.h"
#include "storage/sqlite/query.h"
#include "storage/words_codec.h"

namespace semmap::storage::sqlite {
namespace {

constexpr char kPut[] =
    "INSERT INTO keyframe_words (map_id, keyframe_id, vocabulary, words) VALUES (?, ?, ?, ?) "
    "ON CONFLICT (map_id, keyframe_id) DO UPDATE SET vocabulary = excluded.vocabulary, words = "
    "excluded.words";
constexpr char kErase[] = "DELETE FROM keyframe_words WHERE map_id = ? AND keyframe_id = ?";
constexpr char kSelect[] =
    "SELECT words FROM keyframe_words WHERE map_id = ? AND keyframe_id = ? AND vocabulary = ?";

// nullopt when there are none, or none that can be decoded.
absl::StatusOr<std::optional<std::vector<uint32_t>>> ReadWords(Connection& connection, MapId map,
                                                               uint64_t vocabulary, KeyFrameId keyframe) {
  Query select(connection, kSelect);
  SEMMAP_ASSIGN_OR_RETURN(const bool found, select.Bind(map).Bind(keyframe).Bind(vocabulary).Step());
  std::optional<std::vector<uint32_t>> words;
  if (!found) return words;
  if (auto decoded = DecodeWords(select.Bytes(0)); decoded.ok()) words = *std::move(decoded);
  return words;
}

}  // namespace

absl::Status WriteWords(Connection& connection, MapId map, uint64_t vocabulary, const KeyFrameWords& keyframe,
                        ByteWriter* buffer) {
  EncodeWords(keyframe.words, buffer);
  Query put(connection, kPut);
  return put.Bind(map).Bind(keyframe.id).Bind(vocabulary).BindBlob(buffer->view()).Run();
}

absl::Status AddWords(Connection& connection, MapId map, uint64_t vocabulary, KeyFrameWords keyframe,
                      ByteWriter* buffer) {
  SEMMAP_ASSIGN_OR_RETURN(const auto stored, ReadWords(connection, map, vocabulary, keyframe.id));
  if (!stored) return EraseWords(connection, map, keyframe.id);
  keyframe.words.insert(keyframe.words.end(), stored->begin(), stored->end());
  std::sort(keyframe.words.begin(), keyframe.words.end());
  return WriteWords(connection, map, vocabulary, keyframe, buffer);
}

absl::Status EraseWords(Connection& connection, MapId map, KeyFrameId keyframe) {
  return RunQuery(connection, kErase, map, keyframe);
}

}  // namespace semmap::storage::sqlite
