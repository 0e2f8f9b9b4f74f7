-- Less space for the same map, and when a map last changed.

-- Unix epoch, nanoseconds; NULL: not since this column exists.
ALTER TABLE maps ADD COLUMN updated_at INTEGER;

-- Features come in parts: what was kept when the keyframe was stored, then keypoints of its frame that saw a map point
-- only later. Parts are written once. `kept` lists which keypoints of the frame the part holds (an empty one: all;
-- storage/keypoint_selection.h), and lies before the features so that to read it does not read them.
CREATE TABLE keyframe_parts (
  map_id      INTEGER NOT NULL,
  keyframe_id INTEGER NOT NULL,
  part        INTEGER NOT NULL,
  kept        BLOB NOT NULL,
  features    BLOB NOT NULL,
  PRIMARY KEY (map_id, keyframe_id, part),
  FOREIGN KEY (map_id, keyframe_id) REFERENCES keyframes (map_id, keyframe_id) ON DELETE CASCADE
) STRICT;
INSERT INTO keyframe_parts SELECT map_id, keyframe_id, 0, x'', features FROM keyframe_features;
DROP TABLE keyframe_features;
ALTER TABLE keyframe_parts RENAME TO keyframe_features;

-- With a rowid: a WITHOUT ROWID table keeps a quarter of a page in place and the rest of a row on a page of its own.
CREATE TABLE keyframe_sightings (
  map_id       INTEGER NOT NULL,
  keyframe_id  INTEGER NOT NULL,
  observations BLOB NOT NULL,
  PRIMARY KEY (map_id, keyframe_id),
  FOREIGN KEY (map_id, keyframe_id) REFERENCES keyframes (map_id, keyframe_id) ON DELETE CASCADE
) STRICT;
INSERT INTO keyframe_sightings SELECT map_id, keyframe_id, observations FROM keyframe_observations;
DROP TABLE keyframe_observations;
ALTER TABLE keyframe_sightings RENAME TO keyframe_observations;

-- The key of map and point in one integer, which is the rowid: points are appended to full pages, where a table without
-- rowid leaves a third of each empty.
CREATE TABLE points_by_key (
  -- map_id * 2^40 + point_id
  point_key             INTEGER PRIMARY KEY,
  map_id                INTEGER NOT NULL GENERATED ALWAYS AS (point_key >> 40) VIRTUAL,
  point_id              INTEGER NOT NULL GENERATED ALWAYS AS (point_key & 1099511627775) VIRTUAL,
  -- The cell of the grid that the position is in, three coordinates packed (storage/cell_grid.h).
  cell_key              INTEGER NOT NULL,
  -- Who added it.
  session_id            INTEGER NOT NULL,
  x                     REAL NOT NULL,
  y                     REAL NOT NULL,
  z                     REAL NOT NULL,
  semantic_class        INTEGER NOT NULL,
  class_confidence      REAL NOT NULL,
  observation_count     INTEGER NOT NULL,
  first_seen            INTEGER NOT NULL,
  last_seen             INTEGER NOT NULL,
  reference_keyframe_id INTEGER NOT NULL,
  -- What only the algorithm reads: normal, distances, descriptor, class votes.
  appearance            BLOB NOT NULL,
  FOREIGN KEY (map_id, session_id) REFERENCES sessions (map_id, session_id)
) STRICT;
INSERT INTO points_by_key (point_key, cell_key, session_id, x, y, z, semantic_class, class_confidence,
                           observation_count, first_seen, last_seen, reference_keyframe_id, appearance)
  SELECT (map_id << 40) | point_id, cell_key, session_id, x, y, z, semantic_class, class_confidence,
         observation_count, first_seen, last_seen, reference_keyframe_id, appearance FROM points;
DROP TABLE points;
ALTER TABLE points_by_key RENAME TO points;
CREATE INDEX points_by_cell ON points (map_id, cell_key);
