-- Every table of a map is keyed by map_id first, so that a store can be split by map.
-- Packed values (BLOB) begin with a format byte, except poses: x y z qx qy qz qw, seven doubles, kept as bytes because
-- SQLite's REAL does not tell -0.0 from 0.0. The formats are described in storage/*_codec.h.

CREATE TABLE maps (
  -- AUTOINCREMENT: an id is never used again.
  map_id           INTEGER PRIMARY KEY AUTOINCREMENT CHECK (map_id < 8388608),
  -- NULL while the map is being deleted: it is gone already, its rows follow.
  name             TEXT UNIQUE,
  created_at       INTEGER NOT NULL,
  rig              BLOB NOT NULL,
  scale_known      INTEGER NOT NULL CHECK (scale_known IN (0, 1)),
  latitude_deg     REAL,
  longitude_deg    REAL,
  altitude_m       REAL,
  enu_from_map     BLOB,
  keyframe_count   INTEGER NOT NULL DEFAULT 0 CHECK (keyframe_count >= 0),
  point_count      INTEGER NOT NULL DEFAULT 0 CHECK (point_count >= 0),
  version          INTEGER NOT NULL DEFAULT 0,
  last_keyframe_id INTEGER NOT NULL DEFAULT 0,
  last_point_id    INTEGER NOT NULL DEFAULT 0,
  last_session_id  INTEGER NOT NULL DEFAULT 0,
  -- Edge of the cells of points, in units of the map; chosen when it gets its first points.
  cell_size        REAL,
  CHECK ((latitude_deg IS NULL) = (enu_from_map IS NULL)),
  CHECK ((longitude_deg IS NULL) = (enu_from_map IS NULL)),
  CHECK ((altitude_m IS NULL) = (enu_from_map IS NULL))
) STRICT;

CREATE TABLE sessions (
  map_id                INTEGER NOT NULL REFERENCES maps (map_id),
  session_id            INTEGER NOT NULL,
  -- NULL while the map is being deleted.
  name                  TEXT UNIQUE,
  vehicle_id            TEXT NOT NULL,
  started_at            INTEGER NOT NULL,
  ended_at              INTEGER,
  rig                   BLOB NOT NULL,
  frames_received       INTEGER NOT NULL DEFAULT 0,
  frames_tracked        INTEGER NOT NULL DEFAULT 0,
  stored_frames         INTEGER NOT NULL DEFAULT 0 CHECK (stored_frames >= 0),
  last_durable_sequence INTEGER,
  last_delta_version    INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (map_id, session_id)
) STRICT, WITHOUT ROWID;

CREATE TABLE keyframes (
  map_id            INTEGER NOT NULL,
  keyframe_id       INTEGER NOT NULL CHECK (keyframe_id BETWEEN 1 AND 1099511627775),
  -- Who added it.
  session_id        INTEGER NOT NULL,
  sequence          INTEGER NOT NULL,
  timestamp         INTEGER NOT NULL,
  -- NULL: the root of the tree. Not a foreign key: parents and children change within one step, in any order.
  parent_id         INTEGER,
  map_from_camera   BLOB NOT NULL CHECK (length(map_from_camera) = 56),
  keypoint_count    INTEGER NOT NULL,
  observation_count INTEGER NOT NULL DEFAULT 0,
  PRIMARY KEY (map_id, keyframe_id),
  FOREIGN KEY (map_id, session_id) REFERENCES sessions (map_id, session_id)
) STRICT, WITHOUT ROWID;
CREATE INDEX keyframes_by_time ON keyframes (map_id, timestamp);
CREATE INDEX keyframes_by_parent ON keyframes (map_id, parent_id);
CREATE INDEX keyframes_by_session ON keyframes (map_id, session_id);

-- Keypoints and descriptors: written once, large, read when somebody relocalizes nearby.
CREATE TABLE keyframe_features (
  map_id      INTEGER NOT NULL,
  keyframe_id INTEGER NOT NULL,
  features    BLOB NOT NULL,
  PRIMARY KEY (map_id, keyframe_id),
  FOREIGN KEY (map_id, keyframe_id) REFERENCES keyframes (map_id, keyframe_id) ON DELETE CASCADE
) STRICT;

-- Which point each keypoint sees: rewritten often, small, so not beside the features.
CREATE TABLE keyframe_observations (
  map_id       INTEGER NOT NULL,
  keyframe_id  INTEGER NOT NULL,
  observations BLOB NOT NULL,
  PRIMARY KEY (map_id, keyframe_id),
  FOREIGN KEY (map_id, keyframe_id) REFERENCES keyframes (map_id, keyframe_id) ON DELETE CASCADE
) STRICT, WITHOUT ROWID;

CREATE TABLE points (
  map_id                INTEGER NOT NULL,
  point_id              INTEGER NOT NULL CHECK (point_id BETWEEN 1 AND 1099511627775),
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
  PRIMARY KEY (map_id, point_id),
  FOREIGN KEY (map_id, session_id) REFERENCES sessions (map_id, session_id)
) STRICT, WITHOUT ROWID;

CREATE INDEX points_by_cell ON points (map_id, cell_key);

-- A vehicle's frame relative to a keyframe, so that it moves with it.
CREATE TABLE frames (
  map_id               INTEGER NOT NULL,
  session_id           INTEGER NOT NULL,
  sequence             INTEGER NOT NULL,
  timestamp            INTEGER NOT NULL,
  keyframe_id          INTEGER NOT NULL,
  keyframe_from_camera BLOB NOT NULL CHECK (length(keyframe_from_camera) = 56),
  PRIMARY KEY (map_id, session_id, sequence),
  FOREIGN KEY (map_id, session_id) REFERENCES sessions (map_id, session_id),
  FOREIGN KEY (map_id, keyframe_id) REFERENCES keyframes (map_id, keyframe_id)
) STRICT, WITHOUT ROWID;
CREATE INDEX frames_by_keyframe ON frames (map_id, keyframe_id);

-- Where things are, in cells of a grid instead of exact positions: bundle adjustment moves every point of a
-- neighbourhood a little with each keyframe, and hardly any of them into another cell. The map is a dimension.
-- Each cell that has (or had) a point; the points themselves carry its key.
CREATE VIRTUAL TABLE point_cells USING rtree_i32(
  id, map_min, map_max, x_min, x_max, y_min, y_max, z_min, z_max);
-- Each keyframe; id = map_id * 2^40 + keyframe_id.
CREATE VIRTUAL TABLE keyframe_cells USING rtree_i32(
  id, map_min, map_max, x_min, x_max, y_min, y_max, z_min, z_max);
