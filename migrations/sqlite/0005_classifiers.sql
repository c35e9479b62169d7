-- Classifiers of binary words, a stage that needs no pack.

-- SQLite changes no check: a new table takes the old one's place (references are not looked at while migrations run).
create table ensemble_new (
    id          integer primary key,
    key         blob    not null unique check (length(key) = 32),
    kind        text    not null check (kind in ('pack', 'train', 'encode', 'recall', 'classifier', 'grow', 'jam', 'bend')),
    -- Kind, shape or experiment, and precision: jobs of one class run at one speed.
    class       text    not null,
    physics     integer not null,
    lanes       integer not null check (lanes > 0),
    steps       integer not null,
    grain_steps integer not null,
    bytes       integer not null
) strict;

insert into ensemble_new select id, key, kind, class, physics, lanes, steps, grain_steps, bytes from ensemble;
drop table ensemble;
alter table ensemble_new rename to ensemble;
