-- A job whose outcome is archived is done without a lease.

drop trigger job_moves;

-- The moves that `queue` allows; a test keeps the two lists equal.
create trigger job_moves before update of state on job
when old.state <> new.state and (old.state || '>' || new.state) not in (
    'blocked>ready', 'blocked>done', 'blocked>failed', 'blocked>cancelled',
    'ready>leased', 'ready>done', 'ready>cancelled',
    'leased>done', 'leased>failed', 'leased>poisoned', 'leased>ready', 'leased>cancelled',
    'failed>ready', 'failed>blocked', 'poisoned>ready',
    'cancelled>ready', 'cancelled>blocked', 'cancelled>failed')
begin
    select raise(abort, 'a job may not move so');
end;
