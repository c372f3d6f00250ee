-- A simulation whose inputs have changed is made anew: the one before stays as an earlier attempt. A measured closing is there once.

DROP INDEX shot_completed;
CREATE UNIQUE INDEX shot_completed ON shot (campaign_id, kind, number)
  WHERE kind = 'measured' AND outcome IN ('PASS', 'FAIL', 'NOT JUDGED', 'NOT OBSERVED');
