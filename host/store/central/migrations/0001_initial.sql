-- Many benches in one database: the content of their stores, found by its hash. Rows are added and never changed, but for `finished`, the
-- earliest `created` of a sweep and the list of annotations. The search path is set to the schema `powbench`.
-- `hash` is SHA-256 over the content of a row (host/store/content.h); times, conditions and events stand as in the store, byte for byte.

CREATE TABLE schema_version (
  version bigint NOT NULL
);
INSERT INTO schema_version VALUES (0);

CREATE TABLE campaign (
  id              bigint  GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  hash            text    NOT NULL UNIQUE,
  created         text    NOT NULL,             -- UTC, ISO 8601
  name            text    NOT NULL,
  plan            text    NOT NULL,             -- resolved plan, TOML
  plan_hash       text    NOT NULL,
  specimen        text    NOT NULL,             -- resolved specimen, TOML
  specimen_hash   text    NOT NULL,
  rig_file        text    NOT NULL,
  rig_uri         text    NOT NULL,
  rig_identity    text    NOT NULL,
  program_version text    NOT NULL,
  origin          text    NOT NULL,
  finished        boolean NOT NULL
);

CREATE TABLE shot (
  id          bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  campaign_id bigint NOT NULL REFERENCES campaign (id),
  hash        text   NOT NULL UNIQUE,           -- of campaign, shot and record
  kind        text   NOT NULL CHECK (kind IN ('measured', 'simulated')),
  number      bigint NOT NULL,                  -- place in the plan's order, 0 first
  attempt     bigint NOT NULL,                  -- 1 first; the last one is the shot
  repeat      bigint NOT NULL,
  angle_deg   double precision,                 -- commanded, polarity included; NULL: not known
  conditions  text   NOT NULL,                  -- JSON
  outcome     text   NOT NULL,
  reason      text   NOT NULL,
  started     text   NOT NULL,
  UNIQUE (campaign_id, kind, number, attempt)
);
CREATE UNIQUE INDEX shot_completed ON shot (campaign_id, kind, number)
  WHERE kind = 'measured' AND outcome IN ('PASS', 'FAIL', 'NOT JUDGED', 'NOT OBSERVED');

CREATE TABLE record (
  shot_id      bigint PRIMARY KEY REFERENCES shot (id),
  content_hash text   NOT NULL,                 -- SHA-256 of the bare scans
  sample_rate  double precision,                -- Hz
  samples      bigint NOT NULL,
  fire_sample  bigint NOT NULL,
  fire_offset  double precision,                -- s
  gaps         text   NOT NULL,                 -- JSON list of [first, count] or [first, count, channel]
  overruns     bigint NOT NULL,
  crc32        bigint NOT NULL,                 -- as computed by the rig
  rig_shot_id  bigint NOT NULL,
  rig          text   NOT NULL,
  firmware     text   NOT NULL,
  calibration  text   NOT NULL,
  seal         text   NOT NULL,                 -- of this row and its channels
  sealed       text   NOT NULL,                 -- the rig's sealed shot
  packing      text   NOT NULL,                 -- as in the store: host/store/packing.h
  scans        bytea  NOT NULL
);
ALTER TABLE record ALTER COLUMN scans SET STORAGE EXTERNAL;  -- packed already

CREATE TABLE channel (
  shot_id      bigint NOT NULL REFERENCES record (shot_id),
  position     bigint NOT NULL,                 -- within a scan
  name         text   NOT NULL,
  unit         text   NOT NULL,
  scale        double precision,                -- unit per count
  "offset"     double precision,                -- counts
  delay        double precision,                -- s
  corner_hertz double precision,
  clip_low     bigint NOT NULL,
  clip_high    bigint NOT NULL,
  PRIMARY KEY (shot_id, position)
);

CREATE TABLE events (
  shot_id         bigint NOT NULL REFERENCES record (shot_id),
  position        bigint NOT NULL,              -- 0 first; the last one counts
  hash            text   NOT NULL,
  method          text   NOT NULL,
  parameters_hash text   NOT NULL,
  parameters      text   NOT NULL,
  program_version text   NOT NULL,
  events          text   NOT NULL,              -- JSON, SI units
  reached double precision, u_reached double precision,  -- rad; NULL for what is not known
  touch   double precision, u_touch   double precision,  -- s
  bounce  double precision, u_bounce  double precision,  -- s
  settled double precision, u_settled double precision,  -- s
  PRIMARY KEY (shot_id, position)
);

CREATE TABLE prediction (
  shot_id     bigint PRIMARY KEY REFERENCES shot (id),
  hash        text   NOT NULL,
  uncertainty text   NOT NULL                   -- JSON: symbol of the quantity to standard uncertainty, SI
);

CREATE TABLE annotation (
  campaign_id bigint NOT NULL REFERENCES campaign (id),
  position    bigint NOT NULL,                  -- in the order in which they were written
  hash        text   NOT NULL,
  created     text   NOT NULL,
  key         text   NOT NULL,
  text        text   NOT NULL,
  PRIMARY KEY (campaign_id, position)
);

CREATE TABLE sweep (
  id              bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  design_hash     text   NOT NULL UNIQUE,
  created         text   NOT NULL,              -- of equal sweeps the earliest
  design          text   NOT NULL,              -- JSON
  points          bigint NOT NULL,
  columns         text   NOT NULL,              -- names of the numbers of a point, separated by blanks
  program_version text   NOT NULL
);

CREATE TABLE sweep_block (
  sweep_id bigint NOT NULL REFERENCES sweep (id),
  first    bigint NOT NULL,
  count    bigint NOT NULL,
  hash     text   NOT NULL,
  numbers  bytea  NOT NULL,                     -- count x columns, float64 little endian, NaN: not reached
  PRIMARY KEY (sweep_id, first)
);

-- Points of studies, each a pure function of a text that its id is the hash of.
CREATE TABLE point (
  id      text PRIMARY KEY,
  study   text  NOT NULL,                       -- field, fit, ladder, sim
  hash    text  NOT NULL,
  content bytea NOT NULL
);

-- For people with a question in SQL. The customer and the device are those of the annotations, else those of the plan.
CREATE VIEW campaigns AS
  SELECT c.id, c.name, c.created::timestamptz AS created, c.finished, c.origin,
         coalesce(a.customer, substring(c.plan FROM '(?n)^customer = "(.*)"$')) AS customer,
         coalesce(a.device, substring(c.plan FROM '(?n)^device = "(.*)"$')) AS device,
         c.rig_uri, c.rig_identity, c.program_version,
         (SELECT count(DISTINCT number) FROM shot WHERE campaign_id = c.id AND kind = 'measured') AS measured,
         (SELECT count(DISTINCT number) FROM shot WHERE campaign_id = c.id AND kind = 'simulated') AS simulated
  FROM campaign c
  CROSS JOIN LATERAL (
    SELECT (SELECT text FROM annotation WHERE campaign_id = c.id AND key = 'customer' ORDER BY position DESC LIMIT 1) AS customer,
           (SELECT text FROM annotation WHERE campaign_id = c.id AND key = 'device' ORDER BY position DESC LIMIT 1) AS device
  ) a;

-- Every closing once, with the newest extraction of its last attempt; u: standard uncertainty.
CREATE VIEW closings AS
  SELECT s.campaign_id, s.kind, s.number, s.attempt, s.angle_deg, s.outcome, s.reason, s.started::timestamptz AS started,
         degrees(e.reached) AS reached_deg, degrees(e.u_reached) AS u_reached_deg,
         1000 * e.touch AS touch_ms, 1000 * e.u_touch AS u_touch_ms,
         1000 * e.bounce AS bounce_ms, 1000 * e.u_bounce AS u_bounce_ms,
         1000 * e.settled AS settled_ms, 1000 * e.u_settled AS u_settled_ms,
         e.events::jsonb AS events, s.id AS shot_id
  FROM (SELECT DISTINCT ON (campaign_id, kind, number) * FROM shot ORDER BY campaign_id, kind, number, attempt DESC) s
  LEFT JOIN LATERAL (SELECT * FROM events WHERE shot_id = s.id ORDER BY position DESC LIMIT 1) e ON true;
