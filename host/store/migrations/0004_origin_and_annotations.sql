-- A shot may be measured and yet NOT JUDGED or NOT OBSERVED; its angle may be unknown. A campaign says where its records come from
-- (core/origin.h; '' in rows from before). What was learned later stands beside the sealed data, never in it.

CREATE TABLE shot_new (
  id            INTEGER PRIMARY KEY,
  campaign_id   INTEGER NOT NULL REFERENCES campaign (id),
  kind          TEXT    NOT NULL CHECK (kind IN ('measured', 'simulated')),
  number        INTEGER NOT NULL,               -- place in the plan's order, 0 first
  attempt       INTEGER NOT NULL,               -- 1 first
  repeat        INTEGER NOT NULL,
  angle_deg     REAL,                           -- commanded, polarity included; of an import the one found; NULL: not known
  conditions    TEXT    NOT NULL,               -- JSON, null for what is not known
  outcome       TEXT    NOT NULL CHECK (outcome IN ('PASS', 'FAIL', 'ERROR', 'TIMEOUT', 'ABORTED', 'NOT JUDGED', 'NOT OBSERVED')),
  reason        TEXT    NOT NULL,
  started       TEXT    NOT NULL,
  seal          TEXT    NOT NULL,
  UNIQUE (campaign_id, kind, number, attempt)
) STRICT;

INSERT INTO shot_new
  SELECT id, campaign_id, kind, number, attempt, repeat, angle_deg, conditions, outcome, reason, started, seal FROM shot;
DROP TABLE shot;
ALTER TABLE shot_new RENAME TO shot;
CREATE UNIQUE INDEX shot_completed ON shot (campaign_id, kind, number)
  WHERE outcome IN ('PASS', 'FAIL', 'NOT JUDGED', 'NOT OBSERVED');

ALTER TABLE campaign ADD COLUMN origin TEXT NOT NULL DEFAULT '';

CREATE TABLE annotation (
  id          INTEGER PRIMARY KEY,
  campaign_id INTEGER NOT NULL REFERENCES campaign (id),
  created     TEXT    NOT NULL,                 -- UTC, ISO 8601
  key         TEXT    NOT NULL,
  text        TEXT    NOT NULL,
  seal        TEXT    NOT NULL
) STRICT;

CREATE TABLE prediction (
  shot_id     INTEGER PRIMARY KEY REFERENCES shot (id),
  uncertainty TEXT    NOT NULL,                 -- JSON: symbol of the quantity to standard uncertainty, SI
  seal        TEXT    NOT NULL
) STRICT;
