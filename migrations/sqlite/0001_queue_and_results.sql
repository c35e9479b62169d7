-- Sweeps, the jobs they want, and what came of them.
-- Hashes are 32 bytes, ids of sweeps and leases 16; times are milliseconds since 1970, UTC.

create table sweep (
    id         integer primary key,
    uuid       blob    not null unique check (length(uuid) = 16),
    identity   blob    not null unique check (length(identity) = 32),
    name       text    not null,
    model      text    not null check (model in ('memory', 'beam')),
    preset     text    not null,
    spec       text    not null check (json_valid(spec)),
    -- Axes, fixed parameters and reductions, as the planner resolved them.
    plan       text    not null check (json_valid(plan)),
    warnings   text    not null check (json_valid(warnings)),
    priority   integer not null,
    state      text    not null check (state in ('active', 'paused', 'cancelled')),
    points     integer not null check (points > 0),
    created_at integer not null
) strict;

create table idempotency (
    key      text    primary key check (length(key) between 1 and 200),
    identity blob    not null check (length(identity) = 32),
    sweep    integer not null references sweep (id)
) strict, without rowid;

-- Jobs with the same key run side by side, and cost the same.
create table ensemble (
    id          integer primary key,
    key         blob    not null unique check (length(key) = 32),
    kind        text    not null check (kind in ('pack', 'train', 'recall', 'grow', 'jam', 'bend')),
    -- Kind, shape or experiment, and precision: jobs of one class run at one speed.
    class       text    not null,
    physics     integer not null,
    lanes       integer not null check (lanes > 0),
    steps       integer not null,
    grain_steps integer not null,
    bytes       integer not null
) strict;

create table lease (
    id       integer primary key,
    uuid     blob    not null unique check (length(uuid) = 16),
    worker   text    not null references worker (name),
    beat     integer not null default 0,
    taken_at integer not null,
    heard_at integer not null
) strict;

create table worker (
    name         text    primary key check (length(name) between 1 and 200),
    engine       text    not null,
    physics      integer not null,
    memory_bytes integer not null,
    done         integer not null default 0,
    first_seen   integer not null,
    last_seen    integer not null
) strict, without rowid;

create table job (
    id              integer primary key,
    hash            blob    not null unique check (length(hash) = 32),
    ensemble        integer not null references ensemble (id),
    needs           integer references job (id),
    spec            text    not null,
    state           text    not null check (state in ('blocked', 'ready', 'leased', 'done', 'failed', 'poisoned', 'cancelled')),
    lease           integer references lease (id),
    attempts        integer not null default 0,
    losses          integer not null default 0,
    faults          integer not null default 0,
    step            integer not null default 0,
    steps           integer not null default 0,
    checkpoint      blob,
    checkpoint_step integer,
    failure         text,
    check ((state = 'leased') = (lease is not null)),
    check ((state in ('failed', 'poisoned')) = (failure is not null)),
    check ((checkpoint is null) = (checkpoint_step is null))
) strict;

create index job_ready on job (ensemble, checkpoint_step, id) where state = 'ready';
create index job_needs on job (needs) where needs is not null;
create index job_lease on job (lease) where lease is not null;
create index job_set_aside on job (state) where state in ('failed', 'poisoned');

-- The moves that `queue` allows; a test keeps the two lists equal.
create trigger job_moves before update of state on job
when old.state <> new.state and (old.state || '>' || new.state) not in (
    'blocked>ready', 'blocked>failed', 'blocked>cancelled',
    'ready>leased', 'ready>cancelled',
    'leased>done', 'leased>failed', 'leased>poisoned', 'leased>ready', 'leased>cancelled',
    'failed>ready', 'failed>blocked', 'poisoned>ready',
    'cancelled>ready', 'cancelled>blocked', 'cancelled>failed')
begin
    select raise(abort, 'a job may not move so');
end;

-- Which sweep wants which job, for how many of its points and which first; helpers and preparation are for none.
-- The state is the job's, kept by the trigger below.
create table want (
    job         integer not null references job (id),
    sweep       integer not null references sweep (id),
    state       text    not null,
    points      integer not null,
    first_point integer,
    primary key (job, sweep),
    check ((points = 0) = (first_point is null))
) strict, without rowid;

create index want_state on want (sweep, state, job, points);

create trigger want_follows_job after update of state on job
begin
    update want set state = new.state where job = new.id;
end;

create table point (
    sweep      integer not null references sweep (id),
    point      integer not null,
    job        integer not null references job (id),
    parameters text    not null,
    primary key (sweep, point)
) strict, without rowid;

create table outcome (
    job         integer primary key references job (id),
    lease       blob    not null,
    results     text    not null check (json_valid(results)),
    artifacts   text    not null check (json_valid(artifacts)),
    warnings    text    not null check (json_valid(warnings)),
    result_hash blob    not null check (length(result_hash) = 32),
    provenance  text    not null check (json_valid(provenance)),
    finished_at integer not null
) strict;

create table divergence (
    job         integer not null references job (id),
    result_hash blob    not null check (length(result_hash) = 32),
    provenance  text    not null check (json_valid(provenance)),
    reported_at integer not null,
    primary key (job, result_hash)
) strict, without rowid;

create table attempt (
    job        integer not null references job (id),
    attempt    integer not null,
    lease      blob    not null,
    worker     text    not null,
    started_at integer not null,
    ended_at   integer,
    ending     text check (ending in ('done', 'failed', 'lost', 'released', 'cancelled')),
    detail     text,
    primary key (job, attempt),
    check ((ended_at is null) = (ending is null))
) strict, without rowid;

create table event (
    sweep integer not null references sweep (id),
    seq   integer not null,
    at    integer not null,
    kind  text    not null check (kind in ('point', 'state', 'diverged')),
    data  text    not null check (json_valid(data)),
    primary key (sweep, seq)
) strict, without rowid;

-- Speeds of finished jobs, the latest of each class.
create table speed (
    id                     integer primary key,
    class                  text    not null,
    grain_steps_per_second real    not null
) strict;

create index speed_class on speed (class, id);

create table token (
    hash       blob    primary key check (length(hash) = 32),
    name       text    not null,
    scopes     text    not null check (json_valid(scopes)),
    created_at integer not null
) strict, without rowid;
