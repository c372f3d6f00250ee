-- A shot that is being fired now. Its row goes in the transaction that stores the shot: one that is left behind tells of a program
-- that ended in between, with the coil perhaps on.
CREATE TABLE begun (
  campaign_id INTEGER NOT NULL REFERENCES campaign (id),
  number      INTEGER NOT NULL,                  -- as in shot, and so are the next four
  repeat      INTEGER NOT NULL,
  angle_deg   REAL    NOT NULL,
  conditions  TEXT    NOT NULL,
  started     TEXT    NOT NULL,
  machine     TEXT    NOT NULL,                  -- host name of the program that fires
  process     INTEGER NOT NULL,                  -- and its process id there
  seal        TEXT    NOT NULL,
  PRIMARY KEY (campaign_id, number)
) STRICT, WITHOUT ROWID;
