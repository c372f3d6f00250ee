-- Points of studies: each a pure function of a text (specimen, conditions, seed, options, program version) that its id is the hash of.
CREATE TABLE point (
  id      TEXT PRIMARY KEY,                      -- sha256 of the text
  study   TEXT NOT NULL,                         -- field, fit, ladder, sim
  seal    TEXT NOT NULL,
  content BLOB NOT NULL                          -- as the study writes it
) STRICT, WITHOUT ROWID;
