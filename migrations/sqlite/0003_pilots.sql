-- A sweep with a wanted accuracy waits for its pilot, another sweep, and has no points until that has decided.

alter table sweep add column pilot integer references sweep (id);
-- What the pilot decided, and why.
alter table sweep add column choice text check (choice is null or json_valid(choice));

create index sweep_waiting on sweep (pilot) where pilot is not null and choice is null;
