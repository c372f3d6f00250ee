-- Samples are kept packed, without loss (host/store/packing.h); content_hash stays that of the bare scans. Records from before stay
-- bare until `powbench db migrate` packs them. What a list of shots shows stands in one small row beside the events it is from.

ALTER TABLE record ADD COLUMN packing TEXT NOT NULL DEFAULT '';  -- '' bare scans, 'blocks64' packed

CREATE TABLE digest (
  shot_id   INTEGER PRIMARY KEY REFERENCES shot (id),
  events_id INTEGER NOT NULL,                   -- the events these numbers are from
  reached   REAL, u_reached REAL,               -- closing angle, rad; NULL for what is not known
  touch     REAL, u_touch   REAL,               -- s
  bounce    REAL, u_bounce  REAL,               -- s
  settled   REAL, u_settled REAL,               -- s
  seal      TEXT NOT NULL
) STRICT;
