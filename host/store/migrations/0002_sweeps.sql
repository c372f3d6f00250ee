-- Sweeps: many simulated closings of which only a few numbers are kept. A block of points is written in one transaction,
-- so that an interrupted sweep goes on where it stopped.

CREATE TABLE sweep (
  id              INTEGER PRIMARY KEY,
  created         TEXT    NOT NULL,             -- UTC, ISO 8601
  design          TEXT    NOT NULL,             -- JSON: specimen, conditions, axes, sampling, seed, options
  design_hash     TEXT    NOT NULL UNIQUE,      -- sha256 of it
  points          INTEGER NOT NULL,
  columns         TEXT    NOT NULL,             -- names of the numbers of a point, SI, separated by blanks
  program_version TEXT    NOT NULL,
  seal            TEXT    NOT NULL
) STRICT;

CREATE TABLE sweep_block (
  sweep_id INTEGER NOT NULL REFERENCES sweep (id),
  first    INTEGER NOT NULL,                    -- number of its first point
  count    INTEGER NOT NULL,
  seal     TEXT    NOT NULL,
  numbers  BLOB    NOT NULL,                    -- count x columns, float64 little endian, NaN: not reached
  PRIMARY KEY (sweep_id, first)
) STRICT;
