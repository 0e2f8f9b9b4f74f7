-- What people say about a map, and where its anchor comes from.

ALTER TABLE maps ADD COLUMN display_name TEXT NOT NULL DEFAULT '';
-- Keys and values (storage/labels_codec.h); NULL: none.
ALTER TABLE maps ADD COLUMN labels BLOB;
-- 1: given by somebody, 2: fitted to fixes of satellite receivers.
ALTER TABLE maps ADD COLUMN anchor_source INTEGER NOT NULL DEFAULT 1 CHECK (anchor_source IN (1, 2));
ALTER TABLE maps ADD COLUMN anchor_rms_m REAL NOT NULL DEFAULT 0;
-- Grows with every change of name, display name, labels and anchor, as version does with those of the contents.
ALTER TABLE maps ADD COLUMN revision INTEGER NOT NULL DEFAULT 0;
