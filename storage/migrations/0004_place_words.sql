-- What keyframes look like in few bytes, so that the places of a map can be searched without reading its features.

CREATE TABLE keyframe_words (
  map_id      INTEGER NOT NULL,
  keyframe_id INTEGER NOT NULL,
  -- The way in which features became words: words of another are as good as none.
  vocabulary  INTEGER NOT NULL,
  -- Of all stored keypoints of the keyframe (storage/words_codec.h). Follows from the features: the row goes when
  -- keypoints are added, and whoever misses it makes it anew.
  words       BLOB NOT NULL,
  PRIMARY KEY (map_id, keyframe_id),
  FOREIGN KEY (map_id, keyframe_id) REFERENCES keyframes (map_id, keyframe_id) ON DELETE CASCADE
) STRICT;
