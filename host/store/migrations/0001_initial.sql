-- The first schema: campaigns hold shots, a shot may hold one record, a record holds events.
-- Raw samples are immutable; events can be added by later programs and never replace older ones.
-- `seal` is the checksum of a row (what may change, such as `finished`, is outside it).

CREATE TABLE campaign (
  id              INTEGER PRIMARY KEY,
  created         TEXT    NOT NULL,             -- UTC, ISO 8601
  name            TEXT    NOT NULL,
  plan            TEXT    NOT NULL,             -- resolved plan, TOML
  plan_hash       TEXT    NOT NULL,             -- sha256 of it
  specimen        TEXT    NOT NULL,             -- resolved specimen, TOML
  specimen_hash   TEXT    NOT NULL,
  rig_file        TEXT    NOT NULL,             -- resolved rig, TOML
  rig_uri         TEXT    NOT NULL,
  rig_identity    TEXT    NOT NULL,             -- hw_model, hw_serial
  program_version TEXT    NOT NULL,
  finished        INTEGER NOT NULL DEFAULT 0 CHECK (finished IN (0, 1)),
  seal            TEXT    NOT NULL
) STRICT;

CREATE TABLE shot (
  id            INTEGER PRIMARY KEY,
  campaign_id   INTEGER NOT NULL REFERENCES campaign (id),
  kind          TEXT    NOT NULL CHECK (kind IN ('measured', 'simulated')),
  number        INTEGER NOT NULL,               -- place in the plan's order, 0 first
  repeat        INTEGER NOT NULL,
  angle_deg     REAL    NOT NULL,               -- commanded, polarity included
  conditions    TEXT    NOT NULL,               -- JSON
  outcome       TEXT    NOT NULL CHECK (outcome IN ('PASS', 'FAIL', 'ERROR', 'TIMEOUT', 'ABORTED')),
  reason        TEXT    NOT NULL,
  started       TEXT    NOT NULL,
  seal          TEXT    NOT NULL,
  UNIQUE (campaign_id, kind, number)            -- a completed shot is there once
) STRICT;

CREATE TABLE record (
  id           INTEGER PRIMARY KEY,
  shot_id      INTEGER NOT NULL UNIQUE REFERENCES shot (id),
  content_hash TEXT    NOT NULL,                -- sha256 of scans
  sample_rate  REAL    NOT NULL,                -- Hz
  samples      INTEGER NOT NULL,
  fire_sample  INTEGER NOT NULL,
  fire_offset  REAL    NOT NULL,                -- s
  gaps         TEXT    NOT NULL,                -- JSON list of [first, count]
  overruns     INTEGER NOT NULL,
  crc32        INTEGER NOT NULL,                -- as computed by the rig
  rig_shot_id  INTEGER NOT NULL,
  rig          TEXT    NOT NULL,
  firmware     TEXT    NOT NULL,
  calibration  TEXT    NOT NULL,
  seal         TEXT    NOT NULL,                -- of this row and its channels
  scans        BLOB    NOT NULL                 -- samples x channels, int16 little endian
) STRICT;

CREATE TABLE channel (
  record_id    INTEGER NOT NULL REFERENCES record (id),
  position     INTEGER NOT NULL,                -- within a scan
  name         TEXT    NOT NULL,
  unit         TEXT    NOT NULL,
  scale        REAL    NOT NULL,                -- unit per count
  offset       REAL    NOT NULL,                -- counts
  delay        REAL    NOT NULL,                -- s
  corner_hertz REAL    NOT NULL,
  clip_low     INTEGER NOT NULL,
  clip_high    INTEGER NOT NULL,
  PRIMARY KEY (record_id, position)
) STRICT;

CREATE TABLE events (
  id              INTEGER PRIMARY KEY,
  record_id       INTEGER NOT NULL REFERENCES record (id),
  method          TEXT    NOT NULL,
  parameters_hash TEXT    NOT NULL,
  parameters      TEXT    NOT NULL,
  program_version TEXT    NOT NULL,
  events          TEXT    NOT NULL,             -- JSON, 17 digits, null for what is unknown
  seal            TEXT    NOT NULL,
  UNIQUE (record_id, parameters_hash, program_version)
) STRICT;
