-- Failed attempts at a shot stay as history: one row for each attempt, the last of them is the shot. A completed shot is
-- still there once. A record keeps what the rig sealed, as it came.

CREATE TABLE shot_new (
  id            INTEGER PRIMARY KEY,
  campaign_id   INTEGER NOT NULL REFERENCES campaign (id),
  kind          TEXT    NOT NULL CHECK (kind IN ('measured', 'simulated')),
  number        INTEGER NOT NULL,               -- place in the plan's order, 0 first
  attempt       INTEGER NOT NULL,               -- 1 first
  repeat        INTEGER NOT NULL,
  angle_deg     REAL    NOT NULL,               -- commanded, polarity included
  conditions    TEXT    NOT NULL,               -- JSON
  outcome       TEXT    NOT NULL CHECK (outcome IN ('PASS', 'FAIL', 'ERROR', 'TIMEOUT', 'ABORTED')),
  reason        TEXT    NOT NULL,
  started       TEXT    NOT NULL,
  seal          TEXT    NOT NULL,
  UNIQUE (campaign_id, kind, number, attempt)
) STRICT;

INSERT INTO shot_new
  SELECT id, campaign_id, kind, number, 1, repeat, angle_deg, conditions, outcome, reason, started, seal FROM shot;
DROP TABLE shot;
ALTER TABLE shot_new RENAME TO shot;
CREATE UNIQUE INDEX shot_completed ON shot (campaign_id, kind, number) WHERE outcome IN ('PASS', 'FAIL');

ALTER TABLE record ADD COLUMN sealed TEXT NOT NULL DEFAULT '';  -- firmware/sealed_shot.h; '' from no rig
