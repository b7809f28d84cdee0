-- A store as the second format had it: `sqlite3 FILE .dump` of one session of two entries on one
-- object, the rest as small as can be.
PRAGMA journal_mode=WAL;
BEGIN;
CREATE TABLE identity(name TEXT PRIMARY KEY, value INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE blobs(hash TEXT PRIMARY KEY, size INTEGER NOT NULL, refs INTEGER NOT NULL) WITHOUT ROWID;
CREATE TABLE blob_parts(id INTEGER PRIMARY KEY, hash TEXT NOT NULL, part INTEGER NOT NULL,
  data BLOB NOT NULL, UNIQUE(hash, part));
CREATE TABLE models(id INTEGER PRIMARY KEY AUTOINCREMENT, kind INTEGER NOT NULL, name TEXT NOT NULL,
  listed INTEGER NOT NULL, content TEXT NOT NULL, summary TEXT NOT NULL, form TEXT NOT NULL,
  settings BLOB NOT NULL, blob TEXT NOT NULL, base INTEGER NOT NULL, base_name TEXT NOT NULL);
CREATE UNIQUE INDEX listed_models ON models(kind, name) WHERE listed = 1;
CREATE INDEX based_models ON models(base);
CREATE TABLE sessions(id INTEGER PRIMARY KEY, motion TEXT NOT NULL, next INTEGER NOT NULL,
  revision INTEGER NOT NULL, used INTEGER NOT NULL, state TEXT NOT NULL);
CREATE TABLE session_texts(session INTEGER PRIMARY KEY REFERENCES sessions(id) ON DELETE CASCADE,
  text BLOB NOT NULL);
CREATE TABLE session_models(session INTEGER NOT NULL REFERENCES sessions(id) ON DELETE CASCADE,
  model INTEGER NOT NULL REFERENCES models(id), PRIMARY KEY(session, model)) WITHOUT ROWID;
CREATE INDEX models_of_sessions ON session_models(model);
CREATE TABLE entries(session INTEGER NOT NULL REFERENCES sessions(id) ON DELETE CASCADE,
  number INTEGER NOT NULL, entry BLOB NOT NULL, PRIMARY KEY(session, number)) WITHOUT ROWID;
CREATE TABLE edits(asker BLOB NOT NULL, edit INTEGER NOT NULL,
  session INTEGER NOT NULL REFERENCES sessions(id) ON DELETE CASCADE, revision INTEGER NOT NULL,
  message TEXT NOT NULL, PRIMARY KEY(asker, edit)) WITHOUT ROWID;
CREATE INDEX edits_of_sessions ON edits(session, revision);
CREATE TABLE requests(id INTEGER PRIMARY KEY AUTOINCREMENT, asker BLOB NOT NULL,
  request INTEGER NOT NULL, operation TEXT NOT NULL, subject INTEGER NOT NULL,
  UNIQUE(asker, request));
INSERT INTO requests VALUES(1, x'6d65', 7, 'open_session', 1234567890123456);
INSERT INTO identity VALUES('server', 4242424242424242);
INSERT INTO identity VALUES('openings', 3);
INSERT INTO blobs VALUES('d30ca7a7a32bf5772dc5eb2a2e7bd35737eff795ad74f2479b359716b59abdfa', 4, 1);
INSERT INTO blob_parts VALUES(1, 'd30ca7a7a32bf5772dc5eb2a2e7bd35737eff795ad74f2479b359716b59abdfa', 0, x'6d657368');
INSERT INTO models VALUES(1, 1, 'mug', 1, 'content', 'a mug', 'object', x'', 'd30ca7a7a32bf5772dc5eb2a2e7bd35737eff795ad74f2479b359716b59abdfa', 0, '');
INSERT INTO sessions VALUES(1234567890123456, '', 0, 2, 1700000000000000000, 'state');
INSERT INTO session_texts VALUES(1234567890123456, 'text');
INSERT INTO session_models VALUES(1234567890123456, 1);
INSERT INTO entries VALUES(1234567890123456, 0, 'first');
INSERT INTO entries VALUES(1234567890123456, 1, 'second');
INSERT INTO edits VALUES(x'6d65', 4, 1234567890123456, 1, '');
INSERT INTO edits VALUES(x'6d65', 5, 1234567890123456, 2, 'said');
PRAGMA user_version = 2;
COMMIT;
